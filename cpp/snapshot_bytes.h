// Numbers of a snapshot, written and read little-endian. What is read is checked: Bullet believes all.
#pragma once

#include <cstdint>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "bullet/src/bridge.rs.h"
#include "checks.h"
#include "refusal.h"

namespace itarl {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "snapshots are written little-endian");

class Writer {
 public:
  explicit Writer(std::vector<std::uint8_t>& bytes) : bytes_(bytes) { bytes_.clear(); }

  template <typename T>
  void put(T value) {
    static_assert(std::is_arithmetic_v<T>);
    const std::size_t end = bytes_.size();
    bytes_.resize(end + sizeof value);
    std::memcpy(bytes_.data() + end, &value, sizeof value);
  }
  // Three components: the fourth of a btVector3 is never computed with.
  void put(const btVector3& v) {
    for (int i = 0; i < 3; ++i) put(v[i]);
  }
  void put(const btTransform& t) {
    for (int row = 0; row < 3; ++row) put(t.getBasis()[row]);
    put(t.getOrigin());
  }

 private:
  std::vector<std::uint8_t>& bytes_;
};

class Reader {
 public:
  explicit Reader(rust::Slice<const std::uint8_t> bytes) : bytes_(bytes) {}

  template <typename T>
  T get() {
    static_assert(std::is_arithmetic_v<T>);
    if (bytes_.size() - at_ < sizeof(T)) refuse_snapshot("its state ends early");
    T value;
    std::memcpy(&value, bytes_.data() + at_, sizeof value);
    at_ += sizeof value;
    return value;
  }
  btScalar get_finite() {
    const btScalar value = get<btScalar>();
    if (!std::isfinite(value)) refuse_snapshot("its state holds a number that is not finite");
    return value;
  }
  btVector3 get_vector() {
    btVector3 v(0, 0, 0);
    for (int i = 0; i < 3; ++i) v[i] = get_finite();
    return v;
  }
  btVector3 get_vector_in_range() {
    const btVector3 v = get_vector();
    if (!in_range(v)) refuse_snapshot("its state holds a number beyond 1e18");
    return v;
  }
  btTransform get_transform() {
    btTransform t;
    for (int row = 0; row < 3; ++row) t.getBasis()[row] = get_vector();
    t.setOrigin(get_vector());
    // Bullet makes its matrices from unit quaternions; with any other it finds contacts at NaN.
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) {
        const btScalar product = t.getBasis()[i].dot(t.getBasis()[k]);
        if (!(btFabs(product - btScalar(i == k)) < btScalar(1e-3))) {
          refuse_snapshot("its state holds a rotation that is none");
        }
      }
    }
    if (!is_near(t.getOrigin())) refuse_snapshot("its state holds a position beyond 1e9 m");
    return t;
  }
  // A count or an index.
  std::uint32_t get_below(std::uint32_t end, const char* what) {
    const auto value = get<std::uint32_t>();
    if (value >= end) refuse_snapshot(std::string("its state names a ") + what + " out of range");
    return value;
  }
  std::size_t left() const { return bytes_.size() - at_; }

 private:
  rust::Slice<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

}  // namespace itarl
