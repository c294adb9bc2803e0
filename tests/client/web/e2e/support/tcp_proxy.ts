// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { connect, createServer, type AddressInfo, type Server, type Socket } from 'node:net';
import { Transform } from 'node:stream';

/** A browser's connection, and the one to the server that continues it. */
interface Pair {
  readonly browser: Socket;
  readonly server: Socket;
}

/** Passes on so many bytes a second. */
function slowed(rate: number): Transform {
  return new Transform({
    highWaterMark: 1 << 14,
    transform: (data: Buffer, _, done) => void setTimeout(() => done(null, data), (1000 * data.length) / rate),
  });
}

/** A proxy before a server. A test can break its connections, as networks do, while the server runs on. */
export class TcpProxy {
  private readonly pairs = new Set<Pair>();
  private isShut = false;

  private constructor(private readonly listener: Server, private readonly port: number, private readonly rate: number) {
    listener.on('connection', (browser) => this.join(browser));
  }

  /** Forwards to a port of this computer. `rate`: of each connection's answers, bytes a second; 0: as fast as it goes. */
  static async to(port: number, rate = 0): Promise<TcpProxy> {
    const listener = createServer();
    await new Promise<void>((resolve, reject) => listener.once('error', reject).listen(0, '127.0.0.1', resolve));
    return new TcpProxy(listener, port, rate);
  }

  get origin(): string {
    return `http://127.0.0.1:${(this.listener.address() as AddressInfo).port}`;
  }

  /** On open connections, data from the server no longer arrives. Data from the browser still does. */
  holdAnswers(): void {
    for (const { browser, server } of this.pairs) server.unpipe(browser).pause();
  }

  /** Open connections carry nothing more in either direction, and neither end is told. New ones work. */
  freeze(): void {
    this.holdAnswers();
    for (const pair of this.pairs) {
      pair.browser.unpipe(pair.server).pause();
      pair.browser.removeAllListeners('close');  // the server must not learn of a close
    }
  }

  /** Resets new connections until `mend`. Open ones stay. */
  shut(): void {
    this.isShut = true;
  }

  /** Resets all connections, and new ones until `mend`. */
  cut(): void {
    this.shut();
    for (const { browser, server } of this.pairs) {
      browser.resetAndDestroy();
      server.resetAndDestroy();
    }
  }

  mend(): void {
    this.isShut = false;
  }

  /** Closes all connections, without a reset: after a reset of a frozen connection, Node 20 may never exit. */
  close(): void {
    this.listener.close();
    for (const { browser, server } of this.pairs) {
      browser.destroy();
      server.destroy();
    }
  }

  private join(browser: Socket): void {
    if (this.isShut) {
      browser.on('error', () => undefined).resetAndDestroy();
      return;
    }
    const server = connect(this.port, '127.0.0.1');
    const pair = { browser, server };
    this.pairs.add(pair);
    browser.on('error', () => undefined).on('close', () => server.destroy());
    server.on('error', () => undefined).on('close', () => {
      this.pairs.delete(pair);
      browser.destroy();
    });
    browser.pipe(server);
    if (this.rate > 0) server.pipe(slowed(this.rate)).pipe(browser);
    else server.pipe(browser);
  }
}
