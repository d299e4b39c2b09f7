// Vectors of three numbers and matrices, a world in each lane. The operations are those of Bullet's
// btVector3, btMatrix3x3 and btTransform without SSE, in their order.
#pragma once

#include <cstddef>

#include "lockstep/lanes.h"

namespace itarl::lockstep::ITARL_INSTRUCTIONS {
namespace {

template <typename L>
struct Three {
  typename L::V x, y, z;
};

template <typename L>
inline Three<L> load3(const typename L::Scalar* from) {
  return {L::load(from), L::load(from + L::kWidth), L::load(from + 2 * L::kWidth)};
}

template <typename L>
inline typename L::V dot(const Three<L>& a, const Three<L>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

template <typename L>
inline void store3(typename L::Scalar* to, const Three<L>& v) {
  L::store(to, v.x);
  L::store(to + L::kWidth, v.y);
  L::store(to + 2 * L::kWidth, v.z);
}

template <typename L>
inline Three<L> plus(const Three<L>& old, const Three<L>& change, typename L::V delta) {
  return {old.x + change.x * delta, old.y + change.y * delta, old.z + change.z * delta};
}

// For a change that is the negative of `change`.
template <typename L>
inline Three<L> minus(const Three<L>& old, const Three<L>& change, typename L::V delta) {
  return {old.x - change.x * delta, old.y - change.y * delta, old.z - change.z * delta};
}

template <typename L>
inline Three<L> scaled(const Three<L>& n, typename L::V mass) {
  return {n.x * mass, n.y * mass, n.z * mass};
}

template <typename L>
inline Three<L> operator+(const Three<L>& a, const Three<L>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <typename L>
inline Three<L> operator-(const Three<L>& a, const Three<L>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <typename L>
inline Three<L> operator-(const Three<L>& a) {
  return {-a.x, -a.y, -a.z};
}

template <typename L>
inline Three<L> cross(const Three<L>& a, const Three<L>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

template <typename L>
inline typename L::V length(const Three<L>& a) {
  return L::root(dot<L>(a, a));
}

template <typename L>
inline Three<L> normalized(const Three<L>& a) {
  return scaled<L>(a, L::all(1) / length<L>(a));
}

template <typename L>
inline Three<L> select(typename L::Mask mask, const Three<L>& a, const Three<L>& b) {
  return {L::select(mask, a.x, b.x), L::select(mask, a.y, b.y), L::select(mask, a.z, b.z)};
}

template <typename L>
struct Matrix {
  Three<L> rows[3];

  Three<L> column(int i) const {
    const auto pick = [i](const Three<L>& row) { return i == 0 ? row.x : i == 1 ? row.y : row.z; };
    return {pick(rows[0]), pick(rows[1]), pick(rows[2])};
  }
};

template <typename L>
inline Matrix<L> load_matrix(const typename L::Scalar* from) {
  return {{load3<L>(from), load3<L>(from + 3 * L::kWidth), load3<L>(from + 6 * L::kWidth)}};
}

template <typename L>
inline Three<L> times(const Matrix<L>& m, const Three<L>& v) {
  return {dot<L>(m.rows[0], v), dot<L>(m.rows[1], v), dot<L>(m.rows[2], v)};
}

// Each row of `a`, combined of the rows of `b`.
template <typename L>
inline Matrix<L> times(const Matrix<L>& a, const Matrix<L>& b) {
  const auto row = [&b](const Three<L>& v) {
    return scaled<L>(b.rows[0], v.x) + scaled<L>(b.rows[1], v.y) + scaled<L>(b.rows[2], v.z);
  };
  return {{row(a.rows[0]), row(a.rows[1]), row(a.rows[2])}};
}

template <typename L>
inline Matrix<L> inverse(const Matrix<L>& m) {
  const Three<L> columns[3] = {cross<L>(m.rows[1], m.rows[2]), cross<L>(m.rows[2], m.rows[0]),
                               cross<L>(m.rows[0], m.rows[1])};
  const auto s = L::all(1) / dot<L>(m.rows[0], columns[0]);
  const Matrix<L> turned{
      {scaled<L>(columns[0], s), scaled<L>(columns[1], s), scaled<L>(columns[2], s)}};
  return {{turned.column(0), turned.column(1), turned.column(2)}};
}

template <typename L>
struct Pose {
  Matrix<L> basis;
  Three<L> origin;
};

template <typename L>
inline Pose<L> load_pose(const typename L::Scalar* from) {
  return {load_matrix<L>(from), load3<L>(from + 9 * L::kWidth)};
}

template <typename L>
inline Pose<L> times(const Pose<L>& a, const Pose<L>& b) {
  return {times<L>(a.basis, b.basis), times<L>(a.basis, b.origin) + a.origin};
}

}  // namespace
}  // namespace itarl::lockstep::ITARL_INSTRUCTIONS
