// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/** Takes files that are dropped anywhere on the page. `hover` tells whether files are held above it. */
export function acceptDrops(dropped: (files: File[]) => void, hover: (over: boolean) => void): void {
  let depth = 0; // enter and leave are sent for every element below the pointer
  const holdsFiles = (event: DragEvent): boolean => event.dataTransfer?.types.includes('Files') ?? false;
  const change = (by: number): void => {
    depth = Math.max(depth + by, 0);
    hover(depth > 0);
  };
  window.addEventListener('dragenter', (event) => holdsFiles(event) && change(1));
  window.addEventListener('dragleave', (event) => holdsFiles(event) && change(-1));
  window.addEventListener('dragover', (event) => event.preventDefault());
  window.addEventListener('drop', (event) => {
    event.preventDefault();
    change(-depth);
    const files = [...(event.dataTransfer?.files ?? [])];
    if (files.length > 0) dropped(files);
  });
}
