// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { spawn, type ChildProcess } from 'node:child_process';
import { connect, createServer } from 'node:net';

const START_MS = 60_000; // a machine may stall
const PORT_TAKEN = 'Address already in use';

/** The server under test, on the CPU. It can be killed and restarted at the same address. */
export class ServerProcess {
  private child: ChildProcess | undefined;
  private log = '';

  private constructor(
    readonly port: number, private readonly grpcPort: number, private readonly webRoot: string, private more: readonly string[]) {}

  /** Starts the server with more options. Environment: LATTICED, the program. */
  static async start(webRoot: string, more: readonly string[] = []): Promise<ServerProcess> {
    for (let attempt = 1; ; ++attempt) {
      const server = new ServerProcess(await freePort(20_000), await freePort(26_000), webRoot, more);
      try {
        await server.restart();
        return server;
      } catch (error) {
        await server.kill();
        if (attempt === 3 || !server.log.includes(PORT_TAKEN)) throw error; // another test may have taken it meanwhile
      }
    }
  }

  get origin(): string {
    return `${this.more.includes('--tls-cert') ? 'https' : 'http'}://127.0.0.1:${this.port}`;
  }

  get grpcAddress(): string {
    return `127.0.0.1:${this.grpcPort}`;
  }

  /** The server's log so far. */
  get logged(): string {
    return this.log;
  }

  /** Pauses the process, like a machine that has no time for it. Connections stay open. */
  halt(): void {
    this.child!.kill('SIGSTOP');
  }

  /** Resumes the process. */
  goOn(): void {
    this.child!.kill('SIGCONT');
  }

  async restart(more = this.more): Promise<void> {
    this.more = more;
    // On a busy machine a page or the server may be silent for seconds.
    const patience = more.includes('--heartbeat-interval') ? [] : ['--heartbeat-interval', '10s'];
    this.child = spawn(process.env.LATTICED!, [
      '--listen', this.grpcAddress, '--http', `127.0.0.1:${this.port}`, '--web-root', this.webRoot, '--backend', 'cpu', ...patience, ...more]);
    for (const stream of [this.child.stdout!, this.child.stderr!]) stream.on('data', (data: Buffer) => (this.log += data.toString()));
    for (const end = Date.now() + START_MS; Date.now() < end && this.child.exitCode === null;) {
      if ((await isOpen(this.port)) && this.child.exitCode === null) return;
      await new Promise((resolve) => setTimeout(resolve, 50));
    }
    throw new Error(`latticed did not start: ${this.log}`);
  }

  /** Kills the process, as a power cut would. Does nothing if it has already ended. */
  async kill(): Promise<void> {
    const child = this.child!;
    if (child.exitCode !== null || child.signalCode !== null) return;
    const gone = new Promise((resolve) => child.once('exit', resolve));
    child.kill('SIGKILL');
    await gone;
  }
}

function isOpen(port: number): Promise<boolean> {
  return new Promise((resolve) => {
    const socket = connect(port, '127.0.0.1')
      .once('connect', () => {
        socket.destroy();
        resolve(true);
      })
      .once('error', () => resolve(false));
  });
}

/** A free one of 6,000 ports. The system gives none of them to others, so a restarted server can use it again. */
async function freePort(first: 20_000 | 26_000): Promise<number> {
  for (;;) {
    const port = first + Math.floor(6000 * Math.random());
    if (await canListen(port)) return port;
  }
}

function canListen(port: number): Promise<boolean> {
  return new Promise((resolve) => {
    const server = createServer().once('error', () => resolve(false)).listen(port, '127.0.0.1', () => server.close(() => resolve(true)));
  });
}
