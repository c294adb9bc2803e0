// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// usage: node check.mjs MANIFESTS OUT
// Reads the manifests as Kubernetes would: unknown fields and wrong types are errors (TypeScript reads each object as
// OUT/*.ts), values must satisfy the schemas, and every name must lead to something.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { parse, parseAllDocuments } from 'yaml';

const [manifests, out] = process.argv.slice(2);
const read = (name) => readFileSync(join(manifests, 'base', name), 'utf8');
const objectsOf = (name) => parseAllDocuments(read(name)).map((document) => document.toJS());
const kustomization = parse(read('kustomization.yaml'));
const objects = kustomization.resources.flatMap(objectsOf);
const gpu = parse(read('../gpu/kustomization.yaml'));
assert.deepEqual(gpu.resources, ['../base']); // a folder above it would be a cycle
const patches = gpu.patches.flatMap(({ path }) => objectsOf(join('../gpu', path)));

/** The module of an object's kind: apps/v1/StatefulSet. Groups without a dot have none in Kubernetes' names either. */
const moduleOf = ({ apiVersion, kind }) => `kubernetes-models/${apiVersion}/${kind}`;

async function checkSchemas() {
  for (const object of objects) {
    const { [object.kind]: Kind } = await import(moduleOf(object));
    new Kind(object).validate();
  }
}

function checkTypes() {
  mkdirSync(out, { recursive: true });
  const files = [...objects, ...patches].map((object, i) => {
    const { kind } = object;
    const type = patches.includes(object) ? `Part<I${kind}>` : `I${kind}`;
    const file = join(out, `object_${i}.ts`);
    writeFileSync(file, `import type { I${kind} } from '${moduleOf(object)}';
type Part<T> = T extends (infer E)[] ? Part<E>[] : T extends object ? { [K in keyof T]?: Part<T[K]> } : T;
export const it: ${type} = ${JSON.stringify(object, null, 1)};
export type Unused = Part<I${kind}>;
`);
    return file;
  });
  const options = ['--noEmit', '--strict', '--skipLibCheck', '--target', 'es2022', '--module', 'nodenext'];
  execFileSync(process.execPath, [join(dirname(out), 'node_modules/typescript/bin/tsc'), ...options, ...files], { stdio: 'inherit' });
}

const ofKind = (kind) => objects.filter((object) => object.kind === kind);
const named = (kind, name) => {
  const found = ofKind(kind).filter(({ metadata }) => metadata.name === name);
  assert.equal(found.length, 1, `${kind} ${name}`);
  return found[0];
};
const portsOf = (policy) => policy.flatMap(({ ports }) => ports.map(({ port }) => port));

function checkPods() {
  for (const { spec: { selector, template } } of [...ofKind('StatefulSet'), ...ofKind('Deployment')]) {
    assert.deepEqual(template.metadata.labels, selector.matchLabels);
    const { volumes, containers: [container], securityContext } = template.spec;
    assert.ok(securityContext.runAsNonRoot && container.securityContext.readOnlyRootFilesystem);
    assert.deepEqual(container.securityContext.capabilities, { drop: ['ALL'] });
    assert.ok(kustomization.images.some(({ name }) => name === container.image), container.image);
    assert.deepEqual([...new Set(container.volumeMounts.map(({ name }) => name))], volumes.map(({ name }) => name));
    const probes = Object.entries(container).filter(([key]) => key.endsWith('Probe')).map(([, probe]) => probe.httpGet ?? probe.tcpSocket);
    for (const { port } of probes) assert.ok(container.ports.some(({ name }) => name === port), port);
    for (const { configMap, persistentVolumeClaim } of volumes) {
      if (configMap) assert.ok(kustomization.configMapGenerator.some(({ name }) => name === configMap.name));
      if (persistentVolumeClaim) named('PersistentVolumeClaim', persistentVolumeClaim.claimName);
    }
  }
}

function checkNames() {
  const labels = [...ofKind('StatefulSet'), ...ofKind('Deployment')].map(({ spec }) => spec.selector.matchLabels.app);
  const selectors = [...ofKind('Service').map(({ spec }) => spec.selector), ...ofKind('PodDisruptionBudget').map(({ spec }) => spec.selector.matchLabels)];
  for (const { app } of selectors) assert.ok(labels.includes(app), app);
  assert.equal(kustomization.namespace, ofKind('Namespace')[0].metadata.name);
  for (const { metadata, kind } of patches) named(kind, metadata.name);
  for (const { name } of gpu.images) assert.ok(kustomization.images.some(({ newName }) => newName === name), name);
}

/** The proxies must know every server that the autoscaler may start, by the name that it tells them. */
function checkServers() {
  const { metadata, spec } = named('StatefulSet', 'latticed');
  const [{ env, ports }] = spec.template.spec.containers;
  assert.deepEqual(env.find(({ name }) => name === 'LATTICED_ADVERTISE').valueFrom, { fieldRef: { fieldPath: 'metadata.name' } });
  const { maxReplicas, scaleTargetRef } = named('HorizontalPodAutoscaler', 'latticed').spec;
  named(scaleTargetRef.kind, scaleTargetRef.name);
  const { clusterIP, ports: served } = named('Service', spec.serviceName).spec;
  assert.equal(clusterIP, 'None');
  assert.deepEqual(served.map(({ port }) => port), ports.map(({ containerPort }) => containerPort));
  const [grpc, http, admin] = served.map(({ port }) => port);
  const pods = Array.from({ length: maxReplicas }, (_, i) => `${metadata.name}-${i}`);
  const lines = [...read('haproxy-servers.cfg').matchAll(/^ {2}server (\S+) (\S+):(\d+) .*\bport (\d+)/gm)].map(([, ...words]) => words);
  const known = (port) => pods.map((pod) => [pod, `${pod}.${spec.serviceName}.${kustomization.namespace}.svc.cluster.local`, `${port}`, `${admin}`]);
  assert.deepEqual(lines, [...known(grpc), ...known(http)]);
  assert.deepEqual(portsOf(named('NetworkPolicy', 'servers').spec.ingress), [grpc, http, admin, admin]);
  assert.deepEqual(portsOf(named('NetworkPolicy', 'proxy').spec.egress), [grpc, http, admin]);
}

await checkSchemas();
checkTypes();
checkPods();
checkNames();
checkServers();
console.log(`${objects.length} objects and ${patches.length} patch are as Kubernetes takes them`);
