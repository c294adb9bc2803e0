// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { createClient, type Client, type Interceptor, type Transport } from '@connectrpc/connect';
import { createGrpcWebTransport } from '@connectrpc/connect-web';
import { MeshService } from 'latticed/v1/mesh_pb';
import { SceneService } from 'latticed/v1/scene_pb';
import { ServerService } from 'latticed/v1/server_pb';
import { ShareService } from 'latticed/v1/share_pb';
import { Signal } from '../state/signal';
import { withDeadlines } from './deadlines';

/** The server that the page comes from: gRPC-Web clients of its services, and its address for WebSockets. */
export class LatticedServer {
  readonly scenes: Client<typeof SceneService>;
  readonly meshes: Client<typeof MeshService>;
  readonly server: Client<typeof ServerService>;
  readonly shares: Client<typeof ShareService>;
  /** False once the server has said that the token allows only to watch. */
  mayEdit = true;
  private bearer: string | undefined;
  private readonly renewed = new Signal();

  /**
   * @param origin Scheme, host and port, "http://localhost:8080".
   * @param token Sent as a bearer token if given.
   */
  constructor(
    readonly origin: string,
    token?: string,
    transport?: Transport,
  ) {
    this.bearer = token;
    const interceptors = [withMetadata(() => this.bearer)];
    const timely = withDeadlines(transport ?? createGrpcWebTransport({ baseUrl: origin, interceptors }));
    this.scenes = createClient(SceneService, timely);
    this.meshes = createClient(MeshService, timely);
    this.server = createClient(ServerService, timely);
    this.shares = createClient(ShareService, timely);
  }

  /** Sent with the next calls and streams. */
  get token(): string | undefined {
    return this.bearer;
  }

  /** Whether the token is that of a share, which opens one scene and makes no shares. */
  get isOfShare(): boolean {
    return this.bearer?.startsWith('share-') === true;
  }

  /** Goes on with another token, as after the end of the first. */
  useToken(token: string): void {
    this.bearer = token;
    this.mayEdit = true; // as far as the page knows
    this.renewed.emit();
  }

  /** Calls `listener` after each useToken. Returns a function that removes it. */
  onToken(listener: () => void): () => void {
    return this.renewed.on(listener);
  }
}

/** Adds the token, and as the routing key the scene that a request names. */
function withMetadata(tokenNow: () => string | undefined): Interceptor {
  return (next) => (request) => {
    const token = tokenNow();
    if (token) request.header.set('authorization', `Bearer ${token}`);
    const scene = request.stream ? undefined : sceneOf(request.message);
    if (scene) request.header.set('latticed-scene', scene);
    return next(request);
  };
}

function sceneOf(message: object): string | undefined {
  const { scene, sceneId } = message as { scene?: unknown; sceneId?: unknown };
  if (typeof scene === 'string' && scene) return scene;
  return typeof sceneId === 'string' && sceneId ? sceneId : undefined;
}
