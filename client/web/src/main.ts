// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { App } from './app';
import { Services } from './intake/services';
import { LatticedServer } from './wire/latticed_server';

/** The bearer token, which the address may hold after #token=. Browsers do not send this part to a server. */
const token = new URLSearchParams(location.hash.slice(1)).get('token') ?? undefined;

const app = new App(document.getElementById('app')!, new Services(new LatticedServer(location.origin, token)));
void app.opener.openFromAddress();

/** For the browser's console and for tests. */
declare global {
  interface Window {
    latticed: App;
  }
}
window.latticed = app;
