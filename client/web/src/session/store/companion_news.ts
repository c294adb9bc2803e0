// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/** Tells the browser's other windows of this server that what is kept beside a mesh is other than before. */
export class CompanionNews {
  private opened: BroadcastChannel | undefined;

  /** When it is written: who hears of it reads it. */
  tell(mesh: string): void {
    this.channel.postMessage(mesh);
  }

  onNews(listener: (mesh: string) => void): void {
    this.channel.addEventListener('message', ({ data }: MessageEvent<string>) => listener(data));
  }

  /** Opened when it is first of use: outside pages an open one keeps a program from ending. */
  private get channel(): BroadcastChannel {
    return (this.opened ??= new BroadcastChannel('latticed-companions'));
  }
}
