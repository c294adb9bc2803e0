// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/paper/shaders/gl_context.h"

#include <dlfcn.h>
#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <array>
#include <cstdlib>
#include <string_view>

#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed::bench {
namespace {

constexpr EGLint kMostDevices = 32;
constexpr EGLAttrib kCudaDevice = 0;
constexpr std::string_view kVendor = "NVIDIA";
constexpr std::array kEgl{"libEGL.so.1"};
constexpr std::array kGl{"libOpenGL.so.0", "libGL.so.1"};

bool CanOpen(const auto& libraries) {
  for (const char* const name : libraries) {
    if (dlopen(name, RTLD_LAZY | RTLD_LOCAL) != nullptr) return true;  // stays open
  }
  return false;
}

// libepoxy ends the program if it finds no library, so look for them first.
absl::Status CheckLibraries() {
  if (!CanOpen(kEgl)) return absl::UnavailableError("there is no libEGL.so.1");
  if (!CanOpen(kGl))
    return absl::UnavailableError("there is neither libOpenGL.so.0 nor libGL.so.1");
  const char* const all = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  const auto has = [all](const char* extension) {
    return all != nullptr && epoxy_extension_in_string(all, extension);
  };
  // EGL_EXT_device_base is the older name of the two extensions after it.
  const bool devices = has("EGL_EXT_device_base") ||
                       (has("EGL_EXT_device_enumeration") && has("EGL_EXT_device_query"));
  if (!devices) return absl::UnavailableError("this libEGL lists no devices");
  if (!has("EGL_EXT_platform_device")) {
    return absl::UnavailableError("this libEGL has no EGL_EXT_platform_device");
  }
  return absl::OkStatus();
}

bool IsCudaDevice(EGLDeviceEXT device) {
  const char* const extensions = eglQueryDeviceStringEXT(device, EGL_EXTENSIONS);
  if (extensions == nullptr || !epoxy_extension_in_string(extensions, "EGL_NV_device_cuda")) {
    return false;
  }
  EGLAttrib number = -1;
  return eglQueryDeviceAttribEXT(device, EGL_CUDA_DEVICE_NV, &number) == EGL_TRUE &&
         number == kCudaDevice;
}

std::string GlString(GLenum name) {
  const GLubyte* const text = glGetString(name);
  return text == nullptr ? "" : reinterpret_cast<const char*>(text);
}

}  // namespace

absl::StatusOr<std::unique_ptr<GlContext>> GlContext::Make(void* device) {
  const EGLDisplay display = eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, device, nullptr);
  if (display == EGL_NO_DISPLAY || eglInitialize(display, nullptr, nullptr) != EGL_TRUE) {
    return absl::UnavailableError("an EGL device cannot be initialised");
  }
  const std::array<EGLint, 7> attributes{EGL_CONTEXT_MAJOR_VERSION,
                                         4,
                                         EGL_CONTEXT_MINOR_VERSION,
                                         5,
                                         EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                         EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                         EGL_NONE};
  const bool without_config = epoxy_has_egl_extension(display, "EGL_KHR_no_config_context") &&
                              epoxy_has_egl_extension(display, "EGL_KHR_surfaceless_context");
  EGLContext context = EGL_NO_CONTEXT;
  if (without_config && eglBindAPI(EGL_OPENGL_API) == EGL_TRUE) {
    context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes.data());
  }
  if (context == EGL_NO_CONTEXT) {
    return absl::UnavailableError("an EGL device has no OpenGL 4.5 without a surface");
  }
  std::unique_ptr<GlContext> made(new GlContext(display, context));
  LATTICED_RETURN_IF_ERROR(made->MakeCurrent());
  made->description_ = fmt::format("{}, {}", GlString(GL_RENDERER), GlString(GL_VERSION));
  return made;
}

absl::StatusOr<std::unique_ptr<GlContext>> GlContext::Create(ShaderDevice wanted) {
  LATTICED_RETURN_IF_ERROR(CheckLibraries());
  std::array<EGLDeviceEXT, kMostDevices> devices{};
  EGLint count = 0;
  if (eglQueryDevicesEXT(kMostDevices, devices.data(), &count) != EGL_TRUE) count = 0;
  absl::Status why = absl::UnavailableError(
      wanted == ShaderDevice::kAny
          ? "EGL lists no device"
          : fmt::format("none of the {} devices that EGL lists is CUDA's device {}", count,
                        kCudaDevice));
  for (EGLint i = 0; i < count; ++i) {
    EGLDeviceEXT const device = devices[static_cast<size_t>(i)];
    if (wanted == ShaderDevice::kCuda && !IsCudaDevice(device)) continue;
    auto made = Make(device);
    if (!made.ok()) {
      why = made.status();
    } else if (wanted == ShaderDevice::kCuda && !GlString(GL_VENDOR).starts_with(kVendor)) {
      why =
          absl::UnavailableError(fmt::format("OpenGL is \"{}\" of \"{}\" there, not the GPU's own",
                                             (*made)->description(), GlString(GL_VENDOR)));
    } else {
      return made;
    }
  }
  return why;
}

GlContext::~GlContext() {
  if (eglGetCurrentContext() == context_) {
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  }
  eglDestroyContext(display_, context_);
}

absl::Status GlContext::MakeCurrent() const {
  if (eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_TRUE) {
    return absl::OkStatus();
  }
  return absl::UnavailableError("a context of OpenGL cannot be made current");
}

absl::Status GlStatus(const char* what) {
  const GLenum error = glGetError();
  if (error == GL_NO_ERROR) return absl::OkStatus();
  const std::string message = fmt::format("OpenGL, {}: error {:#x}", what, error);
  return error == GL_OUT_OF_MEMORY ? absl::ResourceExhaustedError(message)
                                   : absl::InternalError(message);
}

}  // namespace latticed::bench
