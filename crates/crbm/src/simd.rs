//! Sixteen chains side by side, one a lane, on whatever the processor has.
//!
//! [`Lanes`] lists the few operations that a chain needs. Each is exact or rounded once per lane
//! (IEEE 754), nothing is contracted and nothing crosses lanes, so all implementations give the
//! same bits: one AVX-512 register, two AVX2 registers, or arrays, which the compiler puts into
//! SSE2 registers, or another architecture's.

#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::{__m256, __m256i, __m512, __m512i};

#[cfg(target_arch = "x86_64")]
use pulp::x86::{V3, V4};

/// Chains that go together.
pub(crate) const LANES: usize = 16;

/// The sums over all subsets of three weights: as much as one AVX2 register looks up.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub(crate) struct Sums(pub(crate) [f32; 8]);

/// What runs on lanes, written once for all of them.
pub(crate) trait Kernel {
    /// Must be `#[inline(always)]`, as all that it calls: else it's compiled without the features.
    fn run<L: Lanes>(self, lanes: L);
}

/// Operations on 16 lanes of `f32` or `u32`. Methods take `self` as the proof that the processor
/// has the instructions.
pub(crate) trait Lanes: Copy {
    type Floats: Copy;
    type Words: Copy;

    /// The same in all lanes.
    fn floats(self, value: f32) -> Self::Floats;
    fn words(self, value: u32) -> Self::Words;
    fn load(self, from: &[u32; LANES]) -> Self::Words;
    fn store(self, words: Self::Words, to: &mut [u32; LANES]);

    /// `table[index]`, each index from 0 to 7.
    fn lookup(self, table: &Sums, index: Self::Words) -> Self::Floats;

    fn add(self, a: Self::Floats, b: Self::Floats) -> Self::Floats;
    fn sub(self, a: Self::Floats, b: Self::Floats) -> Self::Floats;
    fn mul(self, a: Self::Floats, b: Self::Floats) -> Self::Floats;
    /// The smaller and the larger; neither is NaN.
    fn min(self, a: Self::Floats, b: Self::Floats) -> Self::Floats;
    fn max(self, a: Self::Floats, b: Self::Floats) -> Self::Floats;
    /// `then` where `a < b`, else 0.
    fn less(self, a: Self::Floats, b: Self::Floats, then: Self::Words) -> Self::Words;

    /// Modulo 2^32.
    fn plus(self, a: Self::Words, b: Self::Words) -> Self::Words;
    fn and(self, a: Self::Words, b: Self::Words) -> Self::Words;
    fn or(self, a: Self::Words, b: Self::Words) -> Self::Words;
    fn xor(self, a: Self::Words, b: Self::Words) -> Self::Words;
    fn left<const BITS: u32>(self, a: Self::Words) -> Self::Words;
    fn right<const BITS: u32>(self, a: Self::Words) -> Self::Words;

    /// The same bits as another type.
    fn as_words(self, a: Self::Floats) -> Self::Words;
    fn as_floats(self, a: Self::Words) -> Self::Floats;
}

/// Which instructions to use. All give the same bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Instructions {
    /// Those that every processor of the architecture has: SSE2 on x86-64.
    Portable,
    /// AVX2, on x86-64.
    Avx2,
    /// AVX-512 with its extensions BW, CD, DQ and VL, on x86-64.
    Avx512,
}

impl Instructions {
    /// What this processor has, the fastest last.
    pub fn available() -> Vec<Self> {
        let all = [Self::Portable, Self::Avx2, Self::Avx512];
        all.into_iter().filter(|instructions| instructions.detect().is_some()).collect()
    }

    /// `None` if this processor doesn't have them.
    pub(crate) fn detect(self) -> Option<Detected> {
        match self {
            Self::Portable => Some(Detected::Portable),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => V3::try_new().map(Detected::Avx2),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => V4::try_new().map(Detected::Avx512),
            #[cfg(not(target_arch = "x86_64"))]
            Self::Avx2 | Self::Avx512 => None,
        }
    }
}

/// [`Instructions`] that the processor has been seen to have.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Detected {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2(V3),
    #[cfg(target_arch = "x86_64")]
    Avx512(V4),
}

impl Detected {
    /// The widest.
    pub(crate) fn best() -> Self {
        let wide = [Instructions::Avx512, Instructions::Avx2];
        wide.into_iter().find_map(Instructions::detect).unwrap_or(Self::Portable)
    }

    pub(crate) fn instructions(self) -> Instructions {
        match self {
            Self::Portable => Instructions::Portable,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(_) => Instructions::Avx2,
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(_) => Instructions::Avx512,
        }
    }

    pub(crate) fn run<K: Kernel>(self, kernel: K) {
        match self {
            Self::Portable => kernel.run(Portable),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(lanes) => lanes.vectorize(Call { kernel, lanes }),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(lanes) => lanes.vectorize(Call { kernel, lanes }),
        }
    }
}

/// A closure in all but `#[inline(always)]`, which closures can't have.
#[cfg(target_arch = "x86_64")]
struct Call<K, L> {
    kernel: K,
    lanes: L,
}

#[cfg(target_arch = "x86_64")]
impl<K: Kernel, L: Lanes> pulp::NullaryFnOnce for Call<K, L> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.kernel.run(self.lanes);
    }
}

/// `fn name(arguments) -> Result { expression }`, always inlined.
macro_rules! inlined {
    ($($name:ident $(<$bits:ident>)? ($self:ident $(, $a:ident: $t:ty)*) -> $r:ty = $e:expr;)*) => {
        $(#[inline(always)] fn $name $(<const $bits: u32>)? ($self $(, $a: $t)*) -> $r { $e })*
    };
}

/// Arrays, and loops over them.
#[derive(Clone, Copy)]
pub(crate) struct Portable;

type FloatArray = [f32; LANES];
type WordArray = [u32; LANES];

#[inline(always)]
fn each<A: Copy, B: Copy, R: Copy + Default>(
    a: [A; LANES],
    b: [B; LANES],
    f: impl Fn(A, B) -> R,
) -> [R; LANES] {
    let mut result = [R::default(); LANES];
    for i in 0..LANES {
        result[i] = f(a[i], b[i]);
    }
    result
}

impl Lanes for Portable {
    type Floats = FloatArray;
    type Words = WordArray;

    #[inline(always)]
    fn store(self, words: WordArray, to: &mut WordArray) {
        *to = words;
    }

    #[inline(always)]
    fn less(self, a: FloatArray, b: FloatArray, then: WordArray) -> WordArray {
        // All ones or zeros, as SSE2's comparison gives.
        let mask = each(a, b, |a, b| if a < b { u32::MAX } else { 0 });
        each(mask, then, |mask, then| mask & then)
    }

    inlined! {
        floats(self, value: f32) -> FloatArray = [value; LANES];
        words(self, value: u32) -> WordArray = [value; LANES];
        load(self, from: &WordArray) -> WordArray = *from;
        lookup(self, table: &Sums, index: WordArray) -> FloatArray =
            each(index, index, |index, _| table.0[index as usize & 7]);
        add(self, a: FloatArray, b: FloatArray) -> FloatArray = each(a, b, |a, b| a + b);
        sub(self, a: FloatArray, b: FloatArray) -> FloatArray = each(a, b, |a, b| a - b);
        mul(self, a: FloatArray, b: FloatArray) -> FloatArray = each(a, b, |a, b| a * b);
        min(self, a: FloatArray, b: FloatArray) -> FloatArray =
            each(a, b, |a, b| if a < b { a } else { b });
        max(self, a: FloatArray, b: FloatArray) -> FloatArray =
            each(a, b, |a, b| if a > b { a } else { b });
        plus(self, a: WordArray, b: WordArray) -> WordArray = each(a, b, u32::wrapping_add);
        and(self, a: WordArray, b: WordArray) -> WordArray = each(a, b, |a, b| a & b);
        or(self, a: WordArray, b: WordArray) -> WordArray = each(a, b, |a, b| a | b);
        xor(self, a: WordArray, b: WordArray) -> WordArray = each(a, b, |a, b| a ^ b);
        left<BITS>(self, a: WordArray) -> WordArray = each(a, a, |a, _| a << BITS);
        right<BITS>(self, a: WordArray) -> WordArray = each(a, a, |a, _| a >> BITS);
        as_words(self, a: FloatArray) -> WordArray = each(a, a, |a, _| a.to_bits());
        as_floats(self, a: WordArray) -> FloatArray = each(a, a, |a, _| f32::from_bits(a));
    }
}

#[cfg(target_arch = "x86_64")]
type FloatPair = [__m256; 2];
#[cfg(target_arch = "x86_64")]
type WordPair = [__m256i; 2];

/// AVX2: lanes 0 to 7, and 8 to 15.
#[cfg(target_arch = "x86_64")]
impl Lanes for V3 {
    type Floats = FloatPair;
    type Words = WordPair;

    #[inline(always)]
    fn store(self, words: WordPair, to: &mut WordArray) {
        *to = pulp::cast(words);
    }

    #[inline(always)]
    fn lookup(self, table: &Sums, index: WordPair) -> FloatPair {
        let table = pulp::cast(table.0);
        index.map(|index| self.avx2._mm256_permutevar8x32_ps(table, index))
    }

    #[inline(always)]
    fn less(self, a: FloatPair, b: FloatPair, then: WordPair) -> WordPair {
        const LESS: i32 = std::arch::x86_64::_CMP_LT_OQ;
        let mask = pair(a, b, |a, b| self.avx._mm256_cmp_ps::<LESS>(a, b));
        pair(mask, then, |mask, then| {
            self.avx2._mm256_and_si256(self.avx._mm256_castps_si256(mask), then)
        })
    }

    inlined! {
        floats(self, value: f32) -> FloatPair = [self.avx._mm256_set1_ps(value); 2];
        words(self, value: u32) -> WordPair = [self.avx._mm256_set1_epi32(value as i32); 2];
        load(self, from: &WordArray) -> WordPair = pulp::cast(*from);
        add(self, a: FloatPair, b: FloatPair) -> FloatPair =
            pair(a, b, |a, b| self.avx._mm256_add_ps(a, b));
        sub(self, a: FloatPair, b: FloatPair) -> FloatPair =
            pair(a, b, |a, b| self.avx._mm256_sub_ps(a, b));
        mul(self, a: FloatPair, b: FloatPair) -> FloatPair =
            pair(a, b, |a, b| self.avx._mm256_mul_ps(a, b));
        min(self, a: FloatPair, b: FloatPair) -> FloatPair =
            pair(a, b, |a, b| self.avx._mm256_min_ps(a, b));
        max(self, a: FloatPair, b: FloatPair) -> FloatPair =
            pair(a, b, |a, b| self.avx._mm256_max_ps(a, b));
        plus(self, a: WordPair, b: WordPair) -> WordPair =
            pair(a, b, |a, b| self.avx2._mm256_add_epi32(a, b));
        and(self, a: WordPair, b: WordPair) -> WordPair =
            pair(a, b, |a, b| self.avx2._mm256_and_si256(a, b));
        or(self, a: WordPair, b: WordPair) -> WordPair =
            pair(a, b, |a, b| self.avx2._mm256_or_si256(a, b));
        xor(self, a: WordPair, b: WordPair) -> WordPair =
            pair(a, b, |a, b| self.avx2._mm256_xor_si256(a, b));
        // With a vector of amounts, since the other intrinsic's constant is an i32; compilers see it.
        left<BITS>(self, a: WordPair) -> WordPair =
            a.map(|a| self.avx2._mm256_sllv_epi32(a, self.avx._mm256_set1_epi32(BITS as i32)));
        right<BITS>(self, a: WordPair) -> WordPair =
            a.map(|a| self.avx2._mm256_srlv_epi32(a, self.avx._mm256_set1_epi32(BITS as i32)));
        as_words(self, a: FloatPair) -> WordPair = a.map(|a| self.avx._mm256_castps_si256(a));
        as_floats(self, a: WordPair) -> FloatPair = a.map(|a| self.avx._mm256_castsi256_ps(a));
    }
}

#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn pair<A: Copy, B: Copy, R>(a: [A; 2], b: [B; 2], f: impl Fn(A, B) -> R) -> [R; 2] {
    [f(a[0], b[0]), f(a[1], b[1])]
}

/// AVX-512: all lanes in a register.
#[cfg(target_arch = "x86_64")]
impl Lanes for V4 {
    type Floats = __m512;
    type Words = __m512i;

    #[inline(always)]
    fn store(self, words: __m512i, to: &mut WordArray) {
        *to = pulp::cast(words);
    }

    #[inline(always)]
    fn lookup(self, table: &Sums, index: __m512i) -> __m512 {
        let twice = self.avx512dq._mm512_broadcast_f32x8(pulp::cast(table.0));
        self.avx512f._mm512_permutexvar_ps(index, twice)
    }

    #[inline(always)]
    fn less(self, a: __m512, b: __m512, then: __m512i) -> __m512i {
        const LESS: i32 = std::arch::x86_64::_CMP_LT_OQ;
        let mask = self.avx512f._mm512_cmp_ps_mask::<LESS>(a, b);
        self.avx512f._mm512_maskz_mov_epi32(mask, then)
    }

    inlined! {
        floats(self, value: f32) -> __m512 = self.avx512f._mm512_set1_ps(value);
        words(self, value: u32) -> __m512i = self.avx512f._mm512_set1_epi32(value as i32);
        load(self, from: &WordArray) -> __m512i = pulp::cast(*from);
        add(self, a: __m512, b: __m512) -> __m512 = self.avx512f._mm512_add_ps(a, b);
        sub(self, a: __m512, b: __m512) -> __m512 = self.avx512f._mm512_sub_ps(a, b);
        mul(self, a: __m512, b: __m512) -> __m512 = self.avx512f._mm512_mul_ps(a, b);
        min(self, a: __m512, b: __m512) -> __m512 = self.avx512f._mm512_min_ps(a, b);
        max(self, a: __m512, b: __m512) -> __m512 = self.avx512f._mm512_max_ps(a, b);
        plus(self, a: __m512i, b: __m512i) -> __m512i = self.avx512f._mm512_add_epi32(a, b);
        and(self, a: __m512i, b: __m512i) -> __m512i = self.avx512f._mm512_and_si512(a, b);
        or(self, a: __m512i, b: __m512i) -> __m512i = self.avx512f._mm512_or_si512(a, b);
        xor(self, a: __m512i, b: __m512i) -> __m512i = self.avx512f._mm512_xor_si512(a, b);
        left<BITS>(self, a: __m512i) -> __m512i = self.avx512f._mm512_slli_epi32::<BITS>(a);
        right<BITS>(self, a: __m512i) -> __m512i = self.avx512f._mm512_srli_epi32::<BITS>(a);
        as_words(self, a: __m512) -> __m512i = self.avx512f._mm512_castps_si512(a);
        as_floats(self, a: __m512i) -> __m512 = self.avx512f._mm512_castsi512_ps(a);
    }
}
