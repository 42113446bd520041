// From exceptions to the status and message of the C API.
#pragma once

#include <exception>
#include <new>
#include <string>

#include "capi/committed.h"
#include "capi/samples.h"
#include "math/memory.h"
#include "pvol/error.h"

namespace pvol::detail {

/// Throws Error where a structure's reserved members are not 0.
template <class Reserved>
void require_cleared(const Reserved& reserved) {
  for (const auto r : reserved) {
    if (r != 0) throw Error("a reserved member is not 0; set the whole structure to 0 first");
  }
}

/// Throws Error where a pointer to `what` is null.
inline void require_not_null(const void* pointer, const char* what) {
  if (pointer == nullptr) throw Error(std::string(what) + " is null");
}

/// Keeps the message and tells who asked to be told.
inline pvol_status fail(pvol_volume& volume, pvol_status status, const char* message) noexcept {
  try {
    volume.message = message;
  } catch (...) {
    volume.message.clear();
  }
  if (volume.error_function != nullptr) {
    volume.error_function(volume.error_user, status, message);
  }
  return status;
}

/// The status of what `work()` does to a volume: no exception leaves.
template <class Work>
pvol_status guarded(pvol_volume* volume, const Work& work) noexcept {
  if (volume == nullptr) return PVOL_INVALID;
  try {
    work();
    return PVOL_OK;
  } catch (const Cancelled&) {
    return fail(*volume, PVOL_CANCELLED, "the commit was cancelled; the volume is unchanged");
  } catch (const NoMemory& e) {
    return fail(*volume, PVOL_NO_MEMORY, e.what());
  } catch (const Error& e) {
    return fail(*volume, PVOL_INVALID, e.what());
  } catch (const std::bad_alloc&) {
    return fail(*volume, PVOL_NO_MEMORY, "not enough memory");
  } catch (const std::exception& e) {
    return fail(*volume, PVOL_FAILED, e.what());
  } catch (...) {
    return fail(*volume, PVOL_FAILED, "an unknown exception was thrown");
  }
}

}  // namespace pvol::detail
