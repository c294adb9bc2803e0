// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { App } from './app';
import { serverServices } from './intake/server_services';
import { readAddress } from './wire/address';
import { LatticedServer } from './wire/latticed_server';

const { origin, token } = readAddress(new URL(location.href));

const app = new App(document.getElementById('app')!, serverServices(new LatticedServer(origin, token)));
void app.opener.openFromAddress();

/** For the browser's console, and for tests that look behind the page. */
declare global {
  interface Window {
    latticed: App;
  }
}
window.latticed = app;
