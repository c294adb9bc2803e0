// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compares the documentation that the server serves with its sources, the .proto files and the READMEs.
import assert from 'node:assert/strict';
import { existsSync, readdirSync, readFileSync, realpathSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { ServerProcess } from './e2e/support/server_process';

const ROOT = join(realpathSync('src'), '../../..');
let server: ServerProcess;

before(async () => {
  server = await ServerProcess.start(realpathSync('../../server/viewer'));
});

after(() => server.kill());

async function page(path: string): Promise<string> {
  const reply = await fetch(`${server.origin}/docs/${path}`);
  assert.equal(reply.status, 200, path);
  assert.match(reply.headers.get('content-type')!, /^text\/html/, path);
  return reply.text();
}

const collapsed = (text: string) => text.replace(/\s+/g, ' ').trim();

/** The text of a page that a reader sees. */
function visible(html: string): string {
  const text = html.replace(/<\/?(a|code|em|strong)\b[^>]*>/g, '').replace(/<[^>]*>/g, ' ');
  const entities: Record<string, string> = { '&lt;': '<', '&gt;': '>', '&quot;': '"', '&amp;': '&', '&#39;': "'" };
  return collapsed(text.replace(/&(lt|gt|quot|amp|#39);/g, (entity) => entities[entity]));
}

/** Each declaration of a .proto file: the name, and the comment before it. */
function declarations(proto: string): { name: string; comment: string }[] {
  const found: { name: string; comment: string }[] = [];
  let comment: string[] = [];
  for (const line of proto.split('\n').map((each) => each.trim())) {
    const name = /^(?:service|rpc|message|enum|oneof) (\w+)|^[\w.<>, ]+ (\w+) = \d+;|^([A-Z0-9_]+) = \d+;/.exec(line);
    if (line.startsWith('//')) comment.push(line.slice(2));
    else if (name) found.push({ name: name[1] ?? name[2] ?? name[3], comment: collapsed(comment.join(' ')) });
    if (!line.startsWith('//')) comment = [];
  }
  return found;
}

test('every rpc, message, field and value of the protos is on its page, with its comment', async () => {
  const folder = join(ROOT, 'proto/latticed/v1');
  let count = 0;
  for (const file of readdirSync(folder)) {
    const text = visible(await page(`reference/${file.replace('.proto', '.html')}`));
    for (const { name, comment } of declarations(readFileSync(join(folder, file), 'utf8'))) {
      assert.ok(comment.length > 0, `${file}: ${name} has no comment`);
      assert.ok(text.includes(name), `${file}: ${name}`);
      assert.ok(text.includes(comment), `${file}: ${name}: ${comment}`);
      ++count;
    }
  }
  assert.ok(count > 400, `${count} declarations`);
});

test('every README is a page with all its headings', async () => {
  const foldersIn = (folder: string) => readdirSync(join(ROOT, folder)).map((name) => `${folder}${name}/`);
  const folders = ['', ...foldersIn(''), ...foldersIn('client/')];
  const readmes = folders.map((folder) => `${folder}README.md`).filter((readme) => existsSync(join(ROOT, readme)));
  assert.ok(readmes.length >= 8, `${readmes}`);
  for (const readme of readmes) {
    const text = visible(await page(readme.replace('README.md', '')));
    const markdown = readFileSync(join(ROOT, readme), 'utf8').replace(/^```.*?^```/gms, '');
    for (const [, heading] of markdown.matchAll(/^#+ (.*)$/gm)) {
      assert.ok(text.includes(heading.replaceAll('`', '')), `${readme}: ${heading}`);
    }
  }
});

test('every link and image of the documentation leads somewhere', async () => {
  const seen = new Map<string, string>();
  const waiting = [`${server.origin}/docs/`];
  const linked = new Set<string>();
  for (let address = waiting.pop(); address !== undefined; address = waiting.pop()) {
    if (seen.has(address)) continue;
    const reply = await fetch(address);
    assert.equal(reply.status, 200, address);
    const isPage = reply.headers.get('content-type')!.startsWith('text/html') && address.includes('/docs/');
    seen.set(address, isPage ? await reply.text() : '');
    for (const [, link] of seen.get(address)!.matchAll(/(?:href|src)="([^"]*)"/g)) {
      const to = new URL(link, address);
      if (to.origin !== server.origin) continue;
      linked.add(to.href);
      waiting.push(to.href.replace(/#.*/, ''));
    }
  }
  for (const [address, anchor] of [...linked].map((link) => link.split('#')).filter(([, anchor]) => anchor !== undefined)) {
    assert.ok(seen.get(address)!.includes(`id="${decodeURIComponent(anchor)}"`), `${address}#${anchor}`);
  }
});
