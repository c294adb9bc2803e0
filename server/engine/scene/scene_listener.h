// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#ifndef LATTICED_SERVER_ENGINE_SCENE_SCENE_LISTENER_H_
#define LATTICED_SERVER_ENGINE_SCENE_SCENE_LISTENER_H_

#include "server/engine/memory/memory_account.h"

namespace latticed {

// Is notified that a scene has something new, or that it was deleted. Called with no lock of the scene
// held, from any thread; must not block.
class SceneListener {
 public:
  virtual ~SceneListener() = default;
  virtual void OnSceneChanged() = 0;
  // Whose listener it is; null: nobody counts them.
  virtual const MemoryAccount* account() const { return nullptr; }
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_SCENE_SCENE_LISTENER_H_
