// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { App } from './app';
import { Services } from './intake/services';
import { tokenIn } from './ui/overlays/token_form';
import { LatticedServer } from './wire/latticed_server';

/** The bearer token, which the address may hold after #token=. Browsers do not send this part to a server. */
const server = new LatticedServer(location.origin, tokenIn(location.hash));
// A link to the open page with another token does not load the page anew. The way back in the history has old tokens.
const known = new Set([server.token]);
server.onToken(() => known.add(server.token));
window.addEventListener('hashchange', () => {
  const token = tokenIn(location.hash);
  if (token !== undefined && !known.has(token)) server.useToken(token);
});

const app = new App(document.getElementById('app')!, new Services(server));
void app.opener.openFromAddress();

/** For the browser's console and for tests. */
declare global {
  interface Window {
    latticed: App;
  }
}
window.latticed = app;
