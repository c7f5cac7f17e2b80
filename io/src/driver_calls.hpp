// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>

namespace handyar::io {

/// The system calls by which a camera's driver is asked; they leave the reason of a failure in
/// errno. A test answers them itself.
class DriverCalls {
 public:
  virtual ~DriverCalls() = default;
  virtual int open(const char* path);  ///< below zero: failed, here and in what follows
  virtual int control(int device, unsigned long request, void* argument);
  virtual void* map(int device, std::size_t bytes, std::int64_t offset);  ///< null: failed
  virtual void unmap(void* at, std::size_t bytes);
  virtual int poll(int device, int timeout_ms);  ///< zero: it was in vain
  virtual void close(int device);
};

/// Those of this system.
DriverCalls& system_calls();

}  // namespace handyar::io
