// Vectors with a world in each lane, in the words that the sweep needs. Each instruction set
// compiles this for itself (sweep_*.cc), in a namespace of its own so that the linker never takes
// one's functions for another's.
//
//   V        the vector, with + - *
//   Mask     a truth value for each lane
//   zero, load, store
//   less     a < b; false where one is not a number
//   select   a where the mask holds, else b
//   any      whether a lane isn't 0
//   larger   |a| or b, whichever is larger; b where a is not a number
//   bits     of a mask, lane 0 lowest
//   at_least, at_most
//            a, or the bound b where a is beyond it; a itself where both are zeros or a is not a
//            number, as in  a < b ? b : a
//   unless   a where c is the same as d, else b
//   all      a number in every lane
//   root, magnitude
//   less_or_same, both, either, opposite
//            of masks, and more of them
#pragma once

#ifdef __SSE2__
#include <immintrin.h>
#endif

#include <cmath>
#include <cstdint>

namespace itarl::lockstep::ITARL_INSTRUCTIONS {

template <typename S, int W>
struct Lanes;

template <typename S>
struct Lanes<S, 1> {
  using Scalar = S;
  using V = S;
  using Mask = bool;
  static constexpr int kWidth = 1;
  static V zero() { return 0; }
  static V load(const S* from) { return *from; }
  static void store(S* to, V v) { *to = v; }
  static Mask less(V a, V b) { return a < b; }
  static V select(Mask mask, V a, V b) { return mask ? a : b; }
  static V at_least(V a, V b) { return a < b ? b : a; }
  static V at_most(V a, V b) { return a > b ? b : a; }
  static V unless(V a, V b, V c, V d) { return c == d ? a : b; }
  static bool any(V a) { return a != 0; }
  static V larger(V a, V b) { return std::fabs(a) > b ? std::fabs(a) : b; }
  static std::uint32_t bits(Mask mask) { return mask; }
  static V all(S s) { return s; }
  static V root(V a) { return std::sqrt(a); }
  static V magnitude(V a) { return std::fabs(a); }
  static Mask less_or_same(V a, V b) { return a <= b; }
  static Mask both(Mask a, Mask b) { return a && b; }
  static Mask either(Mask a, Mask b) { return a || b; }
  static Mask opposite(Mask a) { return !a; }
};

#ifdef __SSE2__
template <>
struct Lanes<float, 4> {
  using Scalar = float;
  using V = __m128;
  using Mask = __m128;
  static constexpr int kWidth = 4;
  static V zero() { return _mm_setzero_ps(); }
  static V load(const float* from) { return _mm_load_ps(from); }
  static void store(float* to, V v) { _mm_store_ps(to, v); }
  static Mask less(V a, V b) { return _mm_cmplt_ps(a, b); }
  static V select(Mask mask, V a, V b) {
    return _mm_or_ps(_mm_and_ps(mask, a), _mm_andnot_ps(mask, b));
  }
  static V at_least(V a, V b) { return _mm_max_ps(b, a); }
  static V at_most(V a, V b) { return _mm_min_ps(b, a); }
  static V unless(V a, V b, V c, V d) { return select(_mm_cmpneq_ps(c, d), b, a); }
  static bool any(V a) { return _mm_movemask_ps(_mm_cmpneq_ps(a, zero())) != 0; }
  static V larger(V a, V b) { return _mm_max_ps(_mm_andnot_ps(_mm_set1_ps(-0.f), a), b); }
  static std::uint32_t bits(Mask mask) { return std::uint32_t(_mm_movemask_ps(mask)); }
  static V all(float s) { return _mm_set1_ps(s); }
  static V root(V a) { return _mm_sqrt_ps(a); }
  static V magnitude(V a) { return _mm_andnot_ps(_mm_set1_ps(-0.f), a); }
  static Mask less_or_same(V a, V b) { return _mm_cmple_ps(a, b); }
  static Mask both(Mask a, Mask b) { return _mm_and_ps(a, b); }
  static Mask either(Mask a, Mask b) { return _mm_or_ps(a, b); }
  static Mask opposite(Mask a) { return _mm_xor_ps(a, _mm_cmpeq_ps(zero(), zero())); }
};
template <>
struct Lanes<double, 2> {
  using Scalar = double;
  using V = __m128d;
  using Mask = __m128d;
  static constexpr int kWidth = 2;
  static V zero() { return _mm_setzero_pd(); }
  static V load(const double* from) { return _mm_load_pd(from); }
  static void store(double* to, V v) { _mm_store_pd(to, v); }
  static Mask less(V a, V b) { return _mm_cmplt_pd(a, b); }
  static V select(Mask mask, V a, V b) {
    return _mm_or_pd(_mm_and_pd(mask, a), _mm_andnot_pd(mask, b));
  }
  static V at_least(V a, V b) { return _mm_max_pd(b, a); }
  static V at_most(V a, V b) { return _mm_min_pd(b, a); }
  static V unless(V a, V b, V c, V d) { return select(_mm_cmpneq_pd(c, d), b, a); }
  static bool any(V a) { return _mm_movemask_pd(_mm_cmpneq_pd(a, zero())) != 0; }
  static V larger(V a, V b) { return _mm_max_pd(_mm_andnot_pd(_mm_set1_pd(-0.), a), b); }
  static std::uint32_t bits(Mask mask) { return std::uint32_t(_mm_movemask_pd(mask)); }
  static V all(double s) { return _mm_set1_pd(s); }
  static V root(V a) { return _mm_sqrt_pd(a); }
  static V magnitude(V a) { return _mm_andnot_pd(_mm_set1_pd(-0.), a); }
  static Mask less_or_same(V a, V b) { return _mm_cmple_pd(a, b); }
  static Mask both(Mask a, Mask b) { return _mm_and_pd(a, b); }
  static Mask either(Mask a, Mask b) { return _mm_or_pd(a, b); }
  static Mask opposite(Mask a) { return _mm_xor_pd(a, _mm_cmpeq_pd(zero(), zero())); }
};
#endif

#ifdef __AVX2__
template <>
struct Lanes<float, 8> {
  using Scalar = float;
  using V = __m256;
  using Mask = __m256;
  static constexpr int kWidth = 8;
  static V zero() { return _mm256_setzero_ps(); }
  static V load(const float* from) { return _mm256_load_ps(from); }
  static void store(float* to, V v) { _mm256_store_ps(to, v); }
  static Mask less(V a, V b) { return _mm256_cmp_ps(a, b, _CMP_LT_OQ); }
  static V select(Mask mask, V a, V b) { return _mm256_blendv_ps(b, a, mask); }
  static V at_least(V a, V b) { return _mm256_max_ps(b, a); }
  static V at_most(V a, V b) { return _mm256_min_ps(b, a); }
  static V unless(V a, V b, V c, V d) { return _mm256_blendv_ps(a, b, _mm256_cmp_ps(c, d, _CMP_NEQ_UQ)); }
  static bool any(V a) { return _mm256_movemask_ps(_mm256_cmp_ps(a, zero(), _CMP_NEQ_UQ)) != 0; }
  static V larger(V a, V b) { return _mm256_max_ps(_mm256_andnot_ps(_mm256_set1_ps(-0.f), a), b); }
  static std::uint32_t bits(Mask mask) { return std::uint32_t(_mm256_movemask_ps(mask)); }
  static V all(float s) { return _mm256_set1_ps(s); }
  static V root(V a) { return _mm256_sqrt_ps(a); }
  static V magnitude(V a) { return _mm256_andnot_ps(_mm256_set1_ps(-0.f), a); }
  static Mask less_or_same(V a, V b) { return _mm256_cmp_ps(a, b, _CMP_LE_OQ); }
  static Mask both(Mask a, Mask b) { return _mm256_and_ps(a, b); }
  static Mask either(Mask a, Mask b) { return _mm256_or_ps(a, b); }
  static Mask opposite(Mask a) { return _mm256_xor_ps(a, _mm256_cmp_ps(zero(), zero(), _CMP_EQ_OQ)); }
};
template <>
struct Lanes<double, 4> {
  using Scalar = double;
  using V = __m256d;
  using Mask = __m256d;
  static constexpr int kWidth = 4;
  static V zero() { return _mm256_setzero_pd(); }
  static V load(const double* from) { return _mm256_load_pd(from); }
  static void store(double* to, V v) { _mm256_store_pd(to, v); }
  static Mask less(V a, V b) { return _mm256_cmp_pd(a, b, _CMP_LT_OQ); }
  static V select(Mask mask, V a, V b) { return _mm256_blendv_pd(b, a, mask); }
  static V at_least(V a, V b) { return _mm256_max_pd(b, a); }
  static V at_most(V a, V b) { return _mm256_min_pd(b, a); }
  static V unless(V a, V b, V c, V d) { return _mm256_blendv_pd(a, b, _mm256_cmp_pd(c, d, _CMP_NEQ_UQ)); }
  static bool any(V a) { return _mm256_movemask_pd(_mm256_cmp_pd(a, zero(), _CMP_NEQ_UQ)) != 0; }
  static V larger(V a, V b) { return _mm256_max_pd(_mm256_andnot_pd(_mm256_set1_pd(-0.), a), b); }
  static std::uint32_t bits(Mask mask) { return std::uint32_t(_mm256_movemask_pd(mask)); }
  static V all(double s) { return _mm256_set1_pd(s); }
  static V root(V a) { return _mm256_sqrt_pd(a); }
  static V magnitude(V a) { return _mm256_andnot_pd(_mm256_set1_pd(-0.), a); }
  static Mask less_or_same(V a, V b) { return _mm256_cmp_pd(a, b, _CMP_LE_OQ); }
  static Mask both(Mask a, Mask b) { return _mm256_and_pd(a, b); }
  static Mask either(Mask a, Mask b) { return _mm256_or_pd(a, b); }
  static Mask opposite(Mask a) { return _mm256_xor_pd(a, _mm256_cmp_pd(zero(), zero(), _CMP_EQ_OQ)); }
};
#endif

#ifdef __AVX512F__
template <>
struct Lanes<float, 16> {
  using Scalar = float;
  using V = __m512;
  using Mask = __mmask16;
  static constexpr int kWidth = 16;
  static V zero() { return _mm512_setzero_ps(); }
  static V load(const float* from) { return _mm512_load_ps(from); }
  static void store(float* to, V v) { _mm512_store_ps(to, v); }
  static Mask less(V a, V b) { return _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ); }
  static V select(Mask mask, V a, V b) { return _mm512_mask_blend_ps(mask, b, a); }
  static V at_least(V a, V b) { return _mm512_max_ps(b, a); }
  static V at_most(V a, V b) { return _mm512_min_ps(b, a); }
  static V unless(V a, V b, V c, V d) { return _mm512_mask_mov_ps(a, _mm512_cmp_ps_mask(c, d, _CMP_NEQ_UQ), b); }
  static bool any(V a) { return _mm512_cmp_ps_mask(a, zero(), _CMP_NEQ_UQ) != 0; }
  static V larger(V a, V b) { return _mm512_max_ps(_mm512_abs_ps(a), b); }
  static std::uint32_t bits(Mask mask) { return mask; }
  static V all(float s) { return _mm512_set1_ps(s); }
  static V root(V a) { return _mm512_sqrt_ps(a); }
  static V magnitude(V a) { return _mm512_abs_ps(a); }
  static Mask less_or_same(V a, V b) { return _mm512_cmp_ps_mask(a, b, _CMP_LE_OQ); }
  static Mask both(Mask a, Mask b) { return Mask(a & b); }
  static Mask either(Mask a, Mask b) { return Mask(a | b); }
  static Mask opposite(Mask a) { return Mask(~a); }
};
template <>
struct Lanes<double, 8> {
  using Scalar = double;
  using V = __m512d;
  using Mask = __mmask8;
  static constexpr int kWidth = 8;
  static V zero() { return _mm512_setzero_pd(); }
  static V load(const double* from) { return _mm512_load_pd(from); }
  static void store(double* to, V v) { _mm512_store_pd(to, v); }
  static Mask less(V a, V b) { return _mm512_cmp_pd_mask(a, b, _CMP_LT_OQ); }
  static V select(Mask mask, V a, V b) { return _mm512_mask_blend_pd(mask, b, a); }
  static V at_least(V a, V b) { return _mm512_max_pd(b, a); }
  static V at_most(V a, V b) { return _mm512_min_pd(b, a); }
  static V unless(V a, V b, V c, V d) { return _mm512_mask_mov_pd(a, _mm512_cmp_pd_mask(c, d, _CMP_NEQ_UQ), b); }
  static bool any(V a) { return _mm512_cmp_pd_mask(a, zero(), _CMP_NEQ_UQ) != 0; }
  static V larger(V a, V b) { return _mm512_max_pd(_mm512_abs_pd(a), b); }
  static std::uint32_t bits(Mask mask) { return mask; }
  static V all(double s) { return _mm512_set1_pd(s); }
  static V root(V a) { return _mm512_sqrt_pd(a); }
  static V magnitude(V a) { return _mm512_abs_pd(a); }
  static Mask less_or_same(V a, V b) { return _mm512_cmp_pd_mask(a, b, _CMP_LE_OQ); }
  static Mask both(Mask a, Mask b) { return Mask(a & b); }
  static Mask either(Mask a, Mask b) { return Mask(a | b); }
  static Mask opposite(Mask a) { return Mask(~a); }
};
#endif

}  // namespace itarl::lockstep::ITARL_INSTRUCTIONS
