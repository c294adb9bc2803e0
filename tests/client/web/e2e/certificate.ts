// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { execFileSync } from 'node:child_process';
import { createHash, X509Certificate } from 'node:crypto';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';

/** A certificate of 127.0.0.1, signed by itself, with its key. */
export class Certificate {
  readonly certFile: string;
  readonly keyFile: string;
  readonly pem: string;

  /** Writes two files into a folder. */
  constructor(folder: string) {
    this.certFile = join(folder, 'server.crt');
    this.keyFile = join(folder, 'server.key');
    execFileSync('openssl', [
      'req', '-x509', '-newkey', 'rsa:2048', '-nodes', '-days', '2', '-subj', '/CN=127.0.0.1',
      '-addext', 'subjectAltName=IP:127.0.0.1', '-keyout', this.keyFile, '-out', this.certFile], { stdio: 'ignore' });
    this.pem = readFileSync(this.certFile, 'utf8');
  }

  /** Of the program latticed. */
  get serverOptions(): string[] {
    return ['--tls-cert', this.certFile, '--tls-key', this.keyFile];
  }

  /** Of Chromium: trusts servers with this key, and no others that it would not trust. */
  get browserOption(): string {
    const key = new X509Certificate(this.pem).publicKey.export({ type: 'spki', format: 'der' });
    return `--ignore-certificate-errors-spki-list=${createHash('sha256').update(key).digest('base64')}`;
  }
}
