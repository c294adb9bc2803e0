// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { LoadingManager } from 'three';
import { findByName } from './corner_layers';

const NOWHERE = 'blob:nowhere'; // fails without asking a server

/** Tells three where a GLB's pictures are: inside the file, or among files dropped with it, never on the network. */
export class GlbPictures {
  readonly manager = new LoadingManager();
  /** Names of missing pictures. */
  readonly missing: string[] = [];
  /** Whether the file names a picture that was dropped. */
  taken = false;
  /** Whether a picture could not be read. */
  broken = false;
  private readonly made: string[] = [];

  constructor(private readonly pictures: readonly File[]) {
    this.manager.setURLModifier((address) => this.addressOf(address));
    this.manager.onError = (address) => (this.broken ||= address !== NOWHERE);
  }

  dispose(): void {
    this.made.forEach((address) => URL.revokeObjectURL(address));
  }

  /** The address that three loads in place of one from the file. */
  private addressOf(address: string): string {
    if (address.startsWith('blob:')) return address; // a picture inside the file, whose address three has made
    if (/^data:/i.test(address)) return this.insideAddress(decoded(address));
    const name = plain(address);
    const picture = findByName(this.pictures, name);
    if (picture !== undefined) {
      this.taken = true;
      return this.make(picture);
    }
    this.missing.push(name);
    return NOWHERE;
  }

  private insideAddress(content: Blob | undefined): string {
    this.broken ||= content === undefined;
    return content === undefined ? NOWHERE : this.make(content);
  }

  private make(content: Blob): string {
    const address = URL.createObjectURL(content);
    this.made.push(address);
    return address;
  }
}

function plain(address: string): string {
  try {
    return decodeURIComponent(address);
  } catch {
    return address; // the name is not escaped
  }
}

/**
 * Decodes a data: address (RFC 2397: a type and its parameters, then base64 or escaped bytes). The page's policy
 * forbids to fetch it. Undefined if it is malformed.
 */
function decoded(address: string): Blob | undefined {
  const comma = address.indexOf(',');
  if (comma < 0) return undefined;
  const [type, ...parameters] = address.slice('data:'.length, comma).split(';').map((word) => word.trim().toLowerCase());
  const isBase64 = parameters.at(-1) === 'base64';
  const text = address.slice(comma + 1).replace(/%([0-9a-f]{2})/gi, (_, hex: string) => String.fromCharCode(parseInt(hex, 16)));
  try {
    const bytes = isBase64 ? atob(text) : text;
    return new Blob([Uint8Array.from(bytes, (letter) => letter.charCodeAt(0))], { type });
  } catch {
    return undefined;
  }
}
