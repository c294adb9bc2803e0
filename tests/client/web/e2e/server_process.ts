// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { spawn, type ChildProcess } from 'node:child_process';
import { createServer, type AddressInfo } from 'node:net';

/** The server under test, on the CPU; it may be killed and started again at the same address. */
export class ServerProcess {
  private child: ChildProcess | undefined;
  private log = '';

  private constructor(
    readonly port: number, private readonly grpcPort: number, private readonly webRoot: string, private readonly more: readonly string[]) {}

  /** With more options of the program. Environment: LATTICED, the program. */
  static async start(webRoot: string, more: readonly string[] = []): Promise<ServerProcess> {
    const server = new ServerProcess(await freePort(), await freePort(), webRoot, more);
    await server.restart();
    return server;
  }

  get origin(): string {
    return `http://127.0.0.1:${this.port}`;
  }

  get grpcAddress(): string {
    return `127.0.0.1:${this.grpcPort}`;
  }

  async restart(): Promise<void> {
    this.child = spawn(process.env.LATTICED!, [
      '--listen', this.grpcAddress, '--http', `127.0.0.1:${this.port}`, '--web-root', this.webRoot, '--backend', 'cpu',
      ...this.more]);
    for (const stream of [this.child.stdout!, this.child.stderr!]) stream.on('data', (data: Buffer) => (this.log += data.toString()));
    for (let attempt = 0; attempt < 200; ++attempt) {
      if (await fetch(this.origin).then((answer) => answer.ok, () => false)) return;
      await new Promise((resolve) => setTimeout(resolve, 50));
    }
    throw new Error(`latticed did not start: ${this.log}`);
  }

  /** As a power cut would. */
  async kill(): Promise<void> {
    const gone = new Promise((resolve) => this.child!.once('exit', resolve));
    this.child!.kill('SIGKILL');
    await gone;
  }
}

function freePort(): Promise<number> {
  return new Promise((resolve, reject) => {
    const server = createServer().once('error', reject).listen(0, '127.0.0.1', () => {
      const { port } = server.address() as AddressInfo;
      server.close(() => resolve(port));
    });
  });
}
