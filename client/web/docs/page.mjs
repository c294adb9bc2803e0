// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The frame of all pages of the documentation: head, list of pages, list of headings. They need no script.
import { posix } from 'node:path';

/** Text, escaped for HTML. */
export function escape(text) {
  return text.replace(/[&<>"]/g, (c) => ({ '&': '&amp;', '<': '&lt;', '>': '&gt;', '"': '&quot;' })[c]);
}

/** The address of `to` in the page `from`, both below /docs/. The index of a folder is the folder's own address. */
export function relative(from, to) {
  const [path, anchor] = to.split('#');
  const link = path === from ? '' : posix.relative(posix.dirname(from), path).replace(/(^|\/)index\.html$/, '$1') || './';
  return anchor === undefined ? link || './' : `${link}#${anchor}`;
}

/** The whole page. `outline` lists its headings {id, text}; `sections` is a list of {title, pages: [{path, label}]}. */
export function pageOf({ path, title, outline, body }, sections) {
  const item = (page) => {
    const current = page.path === path ? ' aria-current="page"' : '';
    return `<li><a href="${relative(path, page.path)}"${current}>${escape(page.label)}</a></li>`;
  };
  const headings = outline.map(({ id, text }) => `<li><a href="#${id}">${escape(text)}</a></li>`);
  return `<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>${escape(title)}${title === 'latticed' ? '' : ' · latticed'}</title>
<link rel="stylesheet" href="${relative(path, 'docs.css')}">
</head>
<body>
<nav aria-label="Pages">
<a class="home" href="${relative(path, '../index.html')}">Viewer</a>
${sections.map((section) => `<h2>${section.title}</h2>\n<ul>${section.pages.map(item).join('\n')}</ul>`).join('\n')}
</nav>
<main>
${body}
</main>
<nav class="outline" aria-label="On this page">
${headings.length === 0 ? '' : `<h2>On this page</h2>\n<ul>${headings.join('\n')}</ul>`}
</nav>
</body>
</html>
`;
}
