// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { App } from './app';
import { serverServices } from './intake/server_services';
import { LatticedServer } from './wire/latticed_server';

/** A bearer token may come in the address, behind #token=, which browsers send to no server. */
const token = new URLSearchParams(location.hash.slice(1)).get('token') ?? undefined;

const app = new App(document.getElementById('app')!, serverServices(new LatticedServer(location.origin, token)));
void app.opener.openFromAddress();
