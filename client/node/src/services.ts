// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Typed grpc-js clients of latticed.v1's services, from the protos.
import * as grpc from '@grpc/grpc-js';
import { loadSync } from '@grpc/proto-loader';
import { fileURLToPath } from 'node:url';
import type { PartCodec } from './backup_file.js';
import type { ProtoGrpcType as BackupProtos } from './generated/backup.js';
import type { ProtoGrpcType as MeshProtos } from './generated/mesh.js';
import type { ProtoGrpcType as SceneProtos } from './generated/scene.js';

const definition = loadSync(['latticed/v1/backup.proto', 'latticed/v1/mesh.proto', 'latticed/v1/scene.proto'], {
  includeDirs: [fileURLToPath(new URL('../protos', import.meta.url))],
  longs: Number,  // ids and counts, all far below 2^53
  enums: String,
  defaults: true,
  oneofs: true,
});
const { v1 } = (grpc.loadPackageDefinition(definition) as unknown as BackupProtos & MeshProtos & SceneProtos).latticed;

// Short pauses before gRPC reconnects, during which calls fail, and pings that notice a silently lost connection.
const options: grpc.ChannelOptions = {
  'grpc.initial_reconnect_backoff_ms': 100,
  'grpc.max_reconnect_backoff_ms': 500,
  'grpc.keepalive_time_ms': 30_000,
  'grpc.keepalive_timeout_ms': 10_000,
};
// Of scenes and their streams, which notice it in 1.5 s. The answer to a ping waits for at most 64 KiB of
// an update, which is what grpc-js lets a server send ahead. Uploads and backups fill the other direction, and have patience.
const attentive: grpc.ChannelOptions = { ...options, 'grpc.keepalive_time_ms': 800, 'grpc.keepalive_timeout_ms': 700 };

export interface Services {
  backups: InstanceType<BackupProtos['latticed']['v1']['BackupService']>;
  meshes: InstanceType<MeshProtos['latticed']['v1']['MeshService']>;
  scenes: InstanceType<SceneProtos['latticed']['v1']['SceneService']>;
}

export function connect(address: string, credentials = grpc.credentials.createInsecure()): Services {
  return {
    backups: new v1.BackupService(address, credentials, options),
    meshes: new v1.MeshService(address, credentials, options),
    scenes: new v1.SceneService(address, credentials, attentive),
  };
}

const { responseSerialize, responseDeserialize } = v1.BackupService.service.Backup;
export const partCodec: PartCodec = { encode: responseSerialize, decode: responseDeserialize };

/** The metadata of every call about a scene: the routing key for proxies. */
export function about(scene: string): grpc.Metadata {
  const metadata = new grpc.Metadata();
  metadata.set('latticed-scene', scene);
  return metadata;
}

/** A unary call as a promise. */
export function call<Reply>(start: (done: (error: grpc.ServiceError | null, reply?: Reply) => void) => unknown):
    Promise<Reply> {
  return new Promise((resolve, reject) => {
    start((error, reply) => (error ? reject(error) : resolve(reply as Reply)));
  });
}
