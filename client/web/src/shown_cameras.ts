// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The cameras that a window has shown to others since its own last move, and where it goes while it follows somebody.
//
// Who follows shows the camera that they follow, so that others may follow them. Two who follow each other would then show
// each other's cameras on and on. So a camera is shown once; where one that was shown comes back, the other one follows too,
// and the window of the smaller id stands where it stood.
import type { CameraPose } from './state/camera_pose';
import { looksLike, sightOf } from './viewport/sight';

const MOST = 64; // others' cameras that are remembered

export class ShownCameras {
  private own: CameraPose | undefined;
  private readonly others: CameraPose[] = [];
  private newest: CameraPose | undefined;

  /** @param show Shows a camera to others. */
  constructor(private readonly show: (camera: CameraPose) => void) {}

  /** The window has moved by itself, or follows nobody any more. */
  stand(own: CameraPose): void {
    this.own = own;
    this.others.length = 0;
    this.pass(own);
  }

  /** Where the window goes, since the person that it follows shows `camera`. `isFirst`: its id is smaller than theirs. */
  goal(camera: CameraPose, isFirst: boolean): CameraPose {
    const wasShown = [this.own!, ...this.others].some((known) => looksLike(sightOf(known), sightOf(camera)));
    if (!wasShown) {
      this.others.push(camera);
      if (this.others.length > MOST) this.others.shift();
      this.pass(camera);
    }
    if (!wasShown || !isFirst) return camera;
    if (this.newest !== this.own) this.pass(this.own!);
    return this.own!;
  }

  private pass(camera: CameraPose): void {
    this.newest = camera;
    this.show(camera);
  }
}
