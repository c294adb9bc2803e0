// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The people at the open scene: who one is oneself, who else is here, and whose camera is followed.
//
//   own camera -> CameraFollower.moved -> LiveSession.announce
//   others' cameras -> take -> leaderOf -> CameraFollower.follow -> own camera
//
// Who follows shows the camera that they follow, not their own on its way there. They say whom they follow: of those who
// follow each other in a circle one has to stand, else they would show each other's cameras on and on.
import { leaderOf } from './session/following';
import type { LiveSession } from './session/live_session';
import type { Presence } from './session/scene_session';
import type { CameraPose } from './state/camera_pose';
import { personOf, randomPerson, type Person } from './state/person';
import type { SettingsStore } from './state/settings';
import { showYouDialog } from './ui/dialogs/you_dialog';
import { FollowingSign } from './ui/overlays/following_sign';
import { People } from './ui/people';
import { CameraFollower } from './viewport/camera_follower';
import { looksLike, sightOf } from './viewport/sight';
import type { Viewport } from './viewport/viewport';

const NOBODY: ReadonlyMap<string, Presence> = new Map();
const ABSENT_MS = 2000; // a new stream, and a person's own new stream, say only after a while that the person is here

export class PeopleHere {
  private readonly dots = new People({ you: () => this.introduce(), other: (id) => this.press(id) });
  private readonly sign = new FollowingSign(() => void this.stop());
  /** The row of dots. */
  readonly element = this.dots.element;
  /** Over the view. */
  readonly overlay = this.sign.element;
  private readonly random = randomPerson();
  private readonly follower: CameraFollower;
  private session: LiveSession | undefined;
  private others = NOBODY;
  private followed: string | undefined;
  private absence: ReturnType<typeof setTimeout> | undefined; // runs while the followed person is not here
  private shown: CameraPose | undefined; // the camera that others were shown last

  /** @param tell Tells the person something. */
  constructor(
    private readonly settings: SettingsStore,
    private readonly viewport: Viewport,
    private readonly tell: (text: string) => void,
  ) {
    const reducedMotion = matchMedia('(prefers-reduced-motion: reduce)');
    this.follower = new CameraFollower(viewport.rig, () => this.moved(), () => !reducedMotion.matches);
    viewport.onFrame(() => this.follower.frame(performance.now()));
    settings.subscribe((now, before) => now.you !== before.you && this.showYou());
    this.refresh();
  }

  /** This window's person. */
  get you(): Person {
    return personOf(this.settings.value.you, this.random);
  }

  /** Shows the people of a scene that has been opened, and oneself to them. */
  open(session: LiveSession): void {
    this.followNobody();
    this.session = session;
    this.others = session.others;
    session.on('presence', (others) => session === this.session && this.take(others));
    session.announce(this.you);
    this.announceCamera();
    this.refresh();
  }

  /** Asks for one's own name and colour. */
  introduce(): void {
    if (this.session === undefined) return;
    const { settings, random } = this;
    showYouDialog({
      you: settings.value.you,
      random,
      longestName: this.session.longestName,
      chosen: (you) => settings.set({ you }),
    });
  }

  /** Follows nobody any more. Returns whether somebody was followed. */
  stop(): boolean {
    if (this.followed === undefined) return false;
    this.followNobody();
    this.announceCamera();
    this.refresh();
    return true;
  }

  private followNobody(): void {
    this.followed = undefined;
    this.follower.stop();
    this.endAbsence();
  }

  private endAbsence(): void {
    clearTimeout(this.absence);
    this.absence = undefined;
  }

  private showYou(): void {
    this.session?.announce(this.you);
    this.refresh();
  }

  private press(id: string): void {
    const wasFollowed = id === this.followed;
    this.stop();
    if (wasFollowed) return;
    this.followed = id;
    this.session?.announce({ following: id });
    this.follow();
    this.refresh();
  }

  private take(others: ReadonlyMap<string, Presence>): void {
    this.others = others;
    this.follower.notice(); // a move of one's own since the last frame ends the following
    this.follow();
    this.refresh();
  }

  /** Goes on to the camera of the person whom the followed one follows, or of the followed one, who may have left for a while. */
  private follow(): void {
    if (this.followed === undefined || this.session === undefined) return;
    const person = this.others.get(this.followed);
    if (person === undefined) return void (this.absence ??= setTimeout(() => this.stop(), ABSENT_MS));
    this.endAbsence();
    const leader = leaderOf(this.session.editorId, this.followed, this.others);
    if (leader === this.session.editorId) return this.stand(person);
    const camera = this.others.get(leader)?.camera;
    if (camera === undefined) return void this.stop();
    this.show(camera);
  }

  /** Stops following a person who follows this window, directly or through others. */
  private stand({ name }: Presence): void {
    this.stop();
    this.tell(`${name || 'Somebody'} follows you, so your camera stays.`);
  }

  /** Goes on to a camera, which may have another projection, and shows it to others. */
  private show(camera: CameraPose): void {
    this.settings.set({ orthographic: 'height' in camera.projection });
    this.follower.follow(sightOf(camera));
    this.viewport.moved();
    if (this.shown !== undefined && looksLike(sightOf(this.shown), sightOf(camera))) return;
    this.shown = camera;
    this.session?.announce({ camera });
  }

  private moved(): void {
    if (!this.stop()) this.announceCamera();
  }

  private announceCamera(): void {
    this.shown = this.viewport.rig.pose();
    this.session?.announce({ camera: this.shown, following: '' });
  }

  private refresh(): void {
    this.dots.show(this.you, this.session?.editorId, this.others, this.followed);
    const person = this.followed === undefined ? undefined : this.others.get(this.followed);
    if (this.absence === undefined) this.sign.show(person); // else the name of who may come again stays
  }
}
