// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// usage: [LATTICED_SERVER=ADDRESS] node dist/backup.js backup FILE
//        [LATTICED_SERVER=ADDRESS] node dist/backup.js restore FILE [--skip-existing]
// Copies all meshes and scenes of a server, with their undo steps, to a file, and back into this or another server.
import { once } from 'node:events';
import { readBackup, writeBackup } from './backup_file.js';
import type { RestoreResponse__Output } from './generated/latticed/v1/RestoreResponse.js';
import { call, connect, partCodec, type Services } from './services.js';

async function backup({ backups }: Services, path: string): Promise<void> {
  const bytes = await writeBackup(path, backups.Backup({}), partCodec);
  console.log(`${path}: ${bytes} bytes`);
}

async function restore({ backups }: Services, path: string, skipExisting: boolean): Promise<void> {
  for (const _ of readBackup(path, partCodec));  // all of the file, before anything is sent
  const done = await call<RestoreResponse__Output>((answered) => {
    let open = true;
    const stream = backups.Restore((error, reply) => {
      open = false;
      stream.emit('drain');  // the server has ended the call, and takes nothing more
      answered(error, reply);
    });
    const send = async (): Promise<void> => {
      stream.write({ options: { skipExisting } });
      for (const part of readBackup(path, partCodec)) {
        if (open && !stream.write({ part })) await once(stream, 'drain');
        if (!open) return;
      }
      stream.end();
    };
    send().catch((error: unknown) => {
      console.error(`backup: ${error instanceof Error ? error.message : error}`);
      stream.cancel();
    });
  });
  console.log(`restored ${done.meshes} meshes and ${done.scenes} scenes; ` +
    `${done.presentMeshes} and ${done.skippedScenes} were there`);
}

const [command, path, ...options] = process.argv.slice(2);
const skips = options[0] === '--skip-existing';
if (!['backup', 'restore'].includes(command ?? '') || path === undefined || options.length > (command === 'restore' && skips ? 1 : 0)) {
  console.error('usage: [LATTICED_SERVER=ADDRESS] node dist/backup.js backup|restore FILE [--skip-existing]');
  process.exit(2);
}
const services = connect(process.env.LATTICED_SERVER ?? '127.0.0.1:50151');
(command === 'backup' ? backup(services, path) : restore(services, path, skips)).catch((error: unknown) => {
  console.error(`backup: ${error instanceof Error ? error.message : error}`);
  process.exit(1);
});
