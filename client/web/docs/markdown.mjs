// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Makes a page of a README. Links to other READMEs lead to their pages; links to other files of the tree become text.
import { readFileSync } from 'node:fs';
import { join, posix } from 'node:path';
import { Marked } from 'marked';
import { escape, relative } from './page.mjs';

/** A page has the folder of its README. */
const pageOfReadme = (readme) => posix.join(posix.dirname(readme), 'index.html');

/** Returns {path, title, outline, body, images}; the images are files below `root`. */
export function readmePage(root, readme, readmes) {
  const folder = posix.dirname(readme);
  const page = pageOfReadme(readme);
  const outline = [];
  const images = [];
  let title = 'latticed';

  const renderer = {
    heading({ tokens, depth, text }) {
      const id = text.toLowerCase().replace(/[^\p{L}\p{N} -]/gu, '').replaceAll(' ', '-');  // as on GitHub
      const content = this.parser.parseInline(tokens);
      const plain = text.replaceAll('`', '');
      if (depth === 1) title = plain;
      if (depth === 2) outline.push({ id, text: plain });
      return `<h${depth} id="${id}">${content}</h${depth}>\n`;
    },
    link({ href, tokens }) {
      const content = this.parser.parseInline(tokens);
      if (/^(https?:|#)/.test(href)) return `<a href="${escape(href)}">${content}</a>`;
      const [target, anchor] = posix.join(folder, href).split('#');
      const known = [target, posix.join(target, 'README.md')].find((path) => readmes.includes(path));
      if (known === undefined) return content;
      const to = pageOfReadme(known) + (anchor === undefined ? '' : `#${anchor}`);
      return `<a href="${relative(page, to)}">${content}</a>`;
    },
    image({ href, text }) {
      const image = posix.join(folder, href);
      images.push(image);
      return `<img src="${relative(page, image)}" alt="${escape(text)}">`;
    },
  };
  const body = new Marked({ renderer }).parse(readFileSync(join(root, readme), 'utf8'));
  return { path: page, title, outline, body, images };
}
