// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Preloaded into a server, loses its device 0 when the file /data/lose appears: a kernel in the server's own context traps.
// The driver then refuses every later call of this process, as it does after an uncorrectable memory error. Other
// processes, and the device's settings, are not touched. test.sh uses it.
#include <dlfcn.h>
#include <pthread.h>
#include <stdio.h>
#include <unistd.h>

static const char kTrap[] =
    ".version 7.0\n.target sm_80\n.address_size 64\n.visible .entry lose()\n{ trap; }\n";

static void* Find(const char* name) {
  void* const driver = dlopen("libcuda.so.1", RTLD_NOW);
  return driver == NULL ? NULL : dlsym(driver, name);
}

// Each call's functions are those of cuda.h; all return 0 for success.
static int Lose(void) {
  int (*retain)(void**, int) = Find("cuDevicePrimaryCtxRetain");
  int (*use)(void*) = Find("cuCtxSetCurrent");
  int (*load)(void**, const void*) = Find("cuModuleLoadData");
  int (*get)(void**, void*, const char*) = Find("cuModuleGetFunction");
  int (*launch)(void*, unsigned, unsigned, unsigned, unsigned, unsigned, unsigned, unsigned, void*,
                void**, void**) = Find("cuLaunchKernel");
  int (*synchronize)(void) = Find("cuCtxSynchronize");
  if (!retain || !use || !load || !get || !launch || !synchronize) return -1;
  void *context = NULL, *module = NULL, *kernel = NULL;
  if (retain(&context, 0) || use(context) || load(&module, kTrap) || get(&kernel, module, "lose"))
    return -2;
  if (launch(kernel, 1, 1, 1, 1, 1, 1, 0, NULL, NULL, NULL)) return -3;
  return synchronize();
}

static void* Wait(void* unused) {
  while (access("/data/lose", F_OK) != 0) usleep(50000);
  fprintf(stderr, "lose_device: the driver says %d\n", Lose());
  return unused;
}

__attribute__((constructor)) static void Start(void) {
  pthread_t thread;
  if (pthread_create(&thread, NULL, Wait, NULL) == 0) pthread_detach(thread);
}
