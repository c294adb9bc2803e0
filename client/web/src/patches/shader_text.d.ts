// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/** The text of a shader, which the bundler puts into the script. */
declare module '*.vert' {
  const text: string;
  export default text;
}
