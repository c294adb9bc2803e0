// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Takes the camera to where somebody else's is, a part of the way with each frame, and notices when anything else moves it.
import type { CameraRig } from './camera_rig';
import { between, isSeen, looksLike, sightOf, type Sight } from './sight';

const EASE_MS = 120; // after this time 37 % of the way are left; others' cameras come every 100 ms
const FIRST_STEP_MS = 16;

export class CameraFollower {
  private goal: Sight | undefined;
  private steppedAt: number | undefined; // undefined at the goal
  private stand: readonly number[];

  /**
   * @param moved Called when the camera was moved by anything but this follower. It follows nobody then.
   * @param isEased Whether the camera goes smoothly, or jumps.
   */
  constructor(
    private readonly rig: Pick<CameraRig, 'camera' | 'target' | 'pose' | 'show'>,
    private readonly moved: () => void,
    private readonly isEased: () => boolean,
  ) {
    this.stand = this.standNow();
  }

  /** Goes there with the next frames. */
  follow(goal: Sight): void {
    this.goal = goal;
    this.stand = this.standNow();
  }

  stop(): void {
    this.goal = undefined;
    this.steppedAt = undefined;
  }

  /** Looks whether the camera was moved. */
  notice(): void {
    const before = this.stand;
    this.stand = this.standNow();
    if (this.stand.every((value, i) => value === before[i])) return;
    this.stop();
    this.moved();
  }

  /** Called before each frame. */
  frame(now: number): void {
    this.notice();
    if (this.goal !== undefined) this.step(this.goal, now);
  }

  private step(goal: Sight, now: number): void {
    if (!isSeen(goal)) return this.stop();
    const seen = sightOf(this.rig.pose());
    if (looksLike(seen, goal)) return void (this.steppedAt = undefined);
    const ms = this.steppedAt === undefined ? FIRST_STEP_MS : now - this.steppedAt;
    this.steppedAt = now;
    if (isSeen(seen)) this.rig.show(between(seen, goal, this.isEased() ? 1 - Math.exp(-ms / EASE_MS) : 1));
    else this.jump(goal);
    this.stand = this.standNow();
  }

  /** Tried once: a rig that cannot get there would be drawn for ever. */
  private jump(goal: Sight): void {
    this.rig.show(goal);
    this.stop();
  }

  /** What only a person or this follower changes; another size of the window does not. */
  private standNow(): number[] {
    const { camera, target } = this.rig;
    const isOrthographic = 'isOrthographicCamera' in camera;
    return [...camera.position.toArray(), ...target.toArray(), camera.zoom, Number(isOrthographic)];
  }
}
