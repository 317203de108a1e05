#pragma once
// File systems that refuse to lock: flock as this program's tests have it (stage_store_test.cpp).

namespace app {

/// While it lives, flock fails with that errno.
class RefusedLock {
  public:
    explicit RefusedLock(int error) { errorOfAll = error; }
    ~RefusedLock() { errorOfAll = 0; }
    RefusedLock(const RefusedLock&) = delete;
    RefusedLock& operator=(const RefusedLock&) = delete;

    static inline int errorOfAll = 0;
};

} // namespace app
