// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { timestampDate } from '@bufbuild/protobuf/wkt';
import { ShareRole, type Share } from 'latticed/v1/share_pb';
import type { LatticedServer } from './latticed_server';

export type GuestRole = 'read' | 'edit';

/** A share of a scene, without its token, which only its maker has seen. */
export interface SceneShare {
  readonly id: string;
  readonly role: GuestRole;
  readonly until: Date;
  readonly madeBy: string;
}

/** The shares of one scene: tokens for people who have none of the server. Errors are ConnectErrors. */
export class SceneShares {
  constructor(private readonly server: LatticedServer, private readonly scene: string) {}

  /** Returns the token. */
  async make(role: GuestRole, seconds: number): Promise<string> {
    const { token } = await this.server.shares.createShare({
      scene: this.scene,
      role: role === 'edit' ? ShareRole.EDIT : ShareRole.READ,
      ttl: { seconds: BigInt(seconds) },
    });
    return token;
  }

  /** Oldest first. */
  async list(): Promise<SceneShare[]> {
    const { shares } = await this.server.shares.listShares({ scene: this.scene });
    return shares.map(shareFrom);
  }

  /** Ends a share, and the sessions of those who came by it. */
  async revoke(shareId: string): Promise<void> {
    await this.server.shares.revokeShare({ scene: this.scene, shareId });
  }
}

function shareFrom({ shareId, role, creator, expireTime }: Share): SceneShare {
  return {
    id: shareId,
    role: role === ShareRole.EDIT ? 'edit' : 'read',
    until: expireTime ? timestampDate(expireTime) : new Date(NaN),
    madeBy: creator,
  };
}
