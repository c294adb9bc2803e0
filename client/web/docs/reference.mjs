// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The reference of the API, from the descriptors of the .proto files: a page for each file of latticed.v1, and one that
// lists every rpc. Comments are shown unchanged, but names of rpcs and types in them become links.
import { posix } from 'node:path';
import { isFieldSet } from '@bufbuild/protobuf';
import {
  FieldDescriptorProto_Label as Label, FieldDescriptorProto_Type as Type, FieldDescriptorProtoSchema,
} from '@bufbuild/protobuf/wkt';
import { escape, relative } from './page.mjs';

const PACKAGE = 'latticed.v1';
// Field numbers of descriptor.proto. The paths of SourceCodeInfo consist of them.
const FILE = { message: 4, enum: 5, service: 6, syntax: 12 };
const MESSAGE = { field: 2, oneof: 8 };
const MEMBER = { method: 2, value: 2 };

const pageOfFile = (file) => `reference/${posix.basename(file.name, '.proto')}.html`;
const shortName = (typeName) => typeName.replace(`.${PACKAGE}.`, '').replace(/^\./, '');

const declarationsIn = (file) => [...file.service, ...file.messageType, ...file.enumType];
const tableOf = (rows) => `<table class="fields"><tbody>${rows.join('\n')}</tbody></table>`;
const numberedRow = (id, number, cells, kind = '') =>
  `<tr id="${id}" class="${kind}"><td class="number">${number}</td>${cells.map((cell) => `<td>${cell}</td>`).join('')}</tr>`;

/** Returns [{path, title, outline, body}]; the list of rpcs comes first. */
export function referencePages(descriptors) {
  const files = descriptors.file.filter((file) => file.package === PACKAGE);
  const places = new Map();  // the name of an rpc or a type -> the address where it is described
  for (const file of files) {
    for (const service of file.service) {
      for (const { name } of service.method) places.set(name, `${pageOfFile(file)}#${service.name}.${name}`);
    }
    for (const { name } of declarationsIn(file)) places.set(name, `${pageOfFile(file)}#${name}`);
  }
  const byServices = (a, b) => b.service.length - a.service.length || a.name.localeCompare(b.name);
  const pages = files.sort(byServices).map((file) => new FilePage(file, places));
  return [indexPage(pages), ...pages.map((page) => page.page())];
}

function indexPage(pages) {
  const path = 'reference/index.html';
  const services = pages.flatMap((page) => page.file.service.map((service, i) => ({ page, service, at: [FILE.service, i] })));
  const tables = services.map(({ page, service, at }) => {
    const rows = service.method.map((method, i) => {
      const first = page.comment([...at, MEMBER.method, i]).split(/(?<=[.;:]) /)[0].replace(/[;:]$/, '.');
      const place = relative(path, `${page.path}#${service.name}.${method.name}`);
      return `<tr><td><a href="${place}"><code>${method.name}</code></a></td><td>${escape(first)}</td></tr>`;
    });
    return `<h2 id="${service.name}">${service.name}</h2>\n${tableOf(rows)}`;
  });
  const body = `<h1>API reference</h1>
<p>Package <code>${PACKAGE}</code>, from the comments of the <code>.proto</code> files. <a href="${relative(path, 'proto/index.html')}">The
guide</a> tells how the rpcs work together.</p>
${tables.join('\n')}`;
  return { path, title: 'All rpcs', outline: services.map(({ service }) => ({ id: service.name, text: service.name })), body };
}

class FilePage {
  constructor(file, places) {
    this.file = file;
    this.places = places;
    this.path = pageOfFile(file);
    const { location } = file.sourceCodeInfo;
    this.comments = new Map(location.map(({ path, leadingComments }) => [path.join('.'), leadingComments]));
  }

  /** The comment before the declaration at `path`, without the licence. */
  comment(path) {
    return (this.comments.get(path.join('.')) ?? '').replace(/^ SPDX-.*\n/gm, '').replace(/^ /gm, '').trim();
  }

  page() {
    const { file } = this;
    const title = posix.basename(file.name);
    const parts = [
      ...file.service.map((service, i) => this.service(service, [FILE.service, i])),
      ...file.messageType.map((message, i) => this.message(message, [FILE.message, i])),
      ...file.enumType.map((type, i) => this.enumeration(type, [FILE.enum, i])),
    ];
    const outline = declarationsIn(file).map(({ name }) => ({ id: name, text: name }));
    const body = `<h1>${title}</h1>\n${this.prose([FILE.syntax])}\n${parts.join('\n')}`;
    return { path: this.path, title, outline, body };
  }

  prose(path) {
    return this.comment(path).split(/\n\n+/).map((paragraph) => `<p>${this.linked(paragraph)}</p>`).join('\n');
  }

  /** The text as HTML, in which names of rpcs and types are links. */
  linked(text) {
    return escape(text).replace(/\b[A-Z]\w*[a-z]\w*\b/g, (name) => this.link(name));
  }

  link(name) {
    const place = this.places.get(name);
    return place === undefined ? name : `<a href="${relative(this.path, place)}">${name}</a>`;
  }

  section(kind, name, path, content) {
    return `<section>\n<h2 id="${name}"><small>${kind}</small> ${name}</h2>\n${this.prose(path)}\n${content}\n</section>`;
  }

  service(service, path) {
    const side = (isStream, typeName) => `${isStream ? 'stream ' : ''}${this.link(shortName(typeName))}`;
    const methods = service.method.map((method, i) => {
      const asked = side(method.clientStreaming, method.inputType);
      const answered = side(method.serverStreaming, method.outputType);
      return `<div class="rpc" id="${service.name}.${method.name}">
<h3>${method.name}</h3>
<p class="signature"><code>rpc ${method.name}(${asked}) returns (${answered})</code></p>
${this.prose([...path, MEMBER.method, i])}
</div>`;
    });
    return this.section('service', service.name, path, methods.join('\n'));
  }

  message(message, path) {
    const rows = [];
    let previous;
    message.field.forEach((field, i) => {
      const isArm = isFieldSet(field, FieldDescriptorProtoSchema.field.oneofIndex) && !field.proto3Optional;
      const oneof = isArm ? field.oneofIndex : undefined;
      if (oneof !== undefined && oneof !== previous) {
        const comment = this.linked(this.comment([...path, MESSAGE.oneof, oneof]));
        rows.push(`<tr class="oneof"><td colspan="4"><code>oneof ${message.oneofDecl[oneof].name}</code> ${comment}</td></tr>`);
      }
      previous = oneof;
      const comment = this.prose([...path, MESSAGE.field, i]);
      const cells = [`<code>${field.name}</code>`, `<code>${this.fieldType(message, field)}</code>`, comment];
      rows.push(numberedRow(`${message.name}.${field.name}`, field.number, cells, isArm ? 'arm' : ''));
    });
    const table = rows.length === 0 ? '<p class="none">No fields.</p>' : tableOf(rows);
    return this.section('message', message.name, path, table);
  }

  fieldType(message, field) {
    const entry = message.nestedType.find(({ name }) => shortName(field.typeName) === `${message.name}.${name}`);
    if (entry !== undefined) return `map&lt;${entry.field.map((part) => this.fieldType(message, part)).join(', ')}&gt;`;
    const isNamed = field.type === Type.MESSAGE || field.type === Type.ENUM;
    const type = isNamed ? this.link(shortName(field.typeName)) : Type[field.type].toLowerCase();
    const label = field.proto3Optional ? 'optional ' : field.label === Label.REPEATED ? 'repeated ' : '';
    return label + type;
  }

  enumeration(type, path) {
    const rows = type.value.map(({ name, number }, i) =>
      numberedRow(`${type.name}.${name}`, number, [`<code>${name}</code>`, this.prose([...path, MEMBER.value, i])]));
    return this.section('enum', type.name, path, tableOf(rows));
  }
}
