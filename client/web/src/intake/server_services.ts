// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The services of a latticed server.
import { fromBinary, type MessageInitShape } from '@bufbuild/protobuf';
import type { LatticeSourceSchema } from 'latticed/v1/lattice_pb';
import { MeshFormat, MeshHeaderSchema, type Mesh, type MeshHeader } from 'latticed/v1/mesh_pb';
import type { Fit } from '../lattice/identity';
import { Lattice } from '../lattice/lattice';
import { CompanionNews } from '../session/companion_news';
import { IndexedSceneStore } from '../session/indexed_scene_store';
import { openSession } from '../session/open_session';
import { storedMesh } from '../session/scene_store';
import { downloadExport } from '../wire/export_download';
import { randomId } from '../wire/ids';
import { fromLattice, vector } from '../wire/lattice_message';
import type { LatticedServer } from '../wire/latticed_server';
import { uploadMesh } from '../wire/upload';
import { fromView, toView } from '../wire/view_message';
import type { MeshFile, MeshFormatName } from './mesh_file';
import type { Services, UploadedMesh } from './services';

const FORMATS: Record<MeshFormatName, MeshFormat> = {
  obj: MeshFormat.OBJ,
  ply: MeshFormat.PLY,
  stl: MeshFormat.STL,
  glb: MeshFormat.GLB,
  drc: MeshFormat.DRACO,
};

const MOST_FETCHED_UNASKED = 64 << 20; // bytes of a mesh: what is shown without them is the shape, plain

const FORMAT_NAMES = Object.keys(FORMATS) as MeshFormatName[];

export function serverServices(server: LatticedServer, news = new CompanionNews()): Services {
  return {
    async mostMeshBytes() {
      const { limits } = await server.server.getServerInfo({});
      return Number(limits?.maxMeshBytes ?? 0);
    },
    async upload(file, progress, signal) {
      const header = { name: file.name, format: FORMATS[file.format] };
      const onProgress = (sent: number, all: number): void => progress(sent / all);
      const mesh = await uploadMesh(server, header, file.content, { onProgress, signal });
      // Where it cannot be kept, who opens a scene of it is told.
      void IndexedSceneStore.ofPage().saveMesh(storedMesh(mesh.id, header, file.content)).catch(() => undefined);
      return describe(mesh);
    },
    async createScene(mesh, lattice, view) {
      const sceneId = randomId();
      await server.scenes.createScene({
        sceneId,
        mesh,
        lattices: [latticeSource(lattice)],
        defaultView: fromView(view),
      });
      return sceneId;
    },
    async downloadMesh(mesh, signal) {
      const { header, content } = await server.downloads.get(mesh, signal);
      const file = meshFile(header, content);
      if (file === undefined) throw new Error('The mesh was not uploaded as a file that this page reads.');
      return file;
    },
    async keptMesh(mesh) {
      const store = IndexedSceneStore.ofPage();
      const [stored, companions] = await Promise.all([store.mesh(mesh), store.companions(mesh)]);
      const file = stored && meshFile(fromBinary(MeshHeaderSchema, stored.header), stored.content);
      return { ...(file && { file }), companions };
    },
    async keepCompanions(mesh, files, beside) {
      await IndexedSceneStore.ofPage().saveCompanions(mesh, files, beside);
      news.tell(mesh);
    },
    onCompanionsKept: (listener) => news.onNews(listener),
    async picturedMesh(id, signal) {
      const { format, hasUvs, totalBytes } = await server.meshes.getMesh({ mesh: id }, { signal });
      if (format !== MeshFormat.GLB || !hasUvs) return undefined;
      const bytes = Number(totalBytes);
      if (bytes > MOST_FETCHED_UNASKED) return { bytes };
      const { header, content } = await server.downloads.get(id, signal);
      const file = meshFile(header, content);
      return { bytes, ...(file && { file }) };
    },
    async describeScene(sceneId) {
      const { mesh, defaultView } = await server.scenes.getScene({ scene: sceneId });
      return { mesh, view: defaultView === undefined ? {} : toView(defaultView) };
    },
    openSession: (sceneId, options) => openSession(server, sceneId, options),
    exportScene: (sceneId, format, ...rest) => downloadExport(server, sceneId, format, ...rest),
  };
}

/** Undefined for a format that no file has. */
function meshFile(header: MeshHeader, content: Blob): MeshFile | undefined {
  const format = FORMAT_NAMES.find((name) => FORMATS[name] === header.format);
  return format && { name: header.name, format, content };
}

function describe(mesh: Mesh): UploadedMesh {
  return {
    id: mesh.id,
    name: mesh.name,
    vertices: Number(mesh.vertices),
    faces: Number(mesh.faces),
    bounds: { min: vector(mesh.bounds?.min), max: vector(mesh.bounds?.max) },
  };
}

function latticeSource(lattice: Fit | Lattice): MessageInitShape<typeof LatticeSourceSchema> {
  if (lattice instanceof Lattice) return { source: { case: 'lattice', value: fromLattice(lattice) } };
  const axes = ([u, v, w]: Fit['size']) => ({ u, v, w });
  const { size, degree, padding } = lattice;
  return { source: { case: 'fit', value: { size: axes(size), degree: axes(degree), padding } } };
}
