// Internal to blend: elementary functions of vectors, with the same result for every instruction set, which those of
// libraries do not promise: they fuse multiplication and addition where they can.
#if defined(FACETSORT_BLEND_VECTOR_MATH_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef FACETSORT_BLEND_VECTOR_MATH_INL_H
#undef FACETSORT_BLEND_VECTOR_MATH_INL_H
#else
#define FACETSORT_BLEND_VECTOR_MATH_INL_H
#endif

#include <cstddef>
#include <cstdint>

HWY_BEFORE_NAMESPACE();
namespace facetsort::blend_internal::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr float log_of_2 = 0.693147181f;

// coefficients[0] + coefficients[1] x + ...
template <class D, std::size_t count>
HWY_INLINE hn::VFromD<D> polynomial(D d, hn::VFromD<D> x, const hn::TFromD<D> (&coefficients)[count]) {
  auto sum = hn::Set(d, coefficients[count - 1]);
  for (std::size_t i = count - 1; i-- > 0;) sum = hn::Add(hn::Mul(sum, x), hn::Set(d, coefficients[i]));
  return sum;
}

// Natural logarithm of normal positive floats, within 2e-7 of it relatively, or absolutely where it is below 1: with
// x = 2^e m and m between sqrt(1/2) and sqrt(2), log(m) is the series of 2 artanh((m - 1) / (m + 1)).
template <class D>
HWY_INLINE hn::VFromD<D> log_of(D d, hn::VFromD<D> x) {
  constexpr float artanh_series[] = {1.0f, 1.0f / 3, 1.0f / 5, 1.0f / 7, 1.0f / 9};
  constexpr std::int32_t bits_of_root_of_half = 0x3f3504f3;
  const hn::RebindToSigned<D> di;
  const auto bits = hn::BitCast(di, x);
  const auto exponent = hn::ShiftRight<23>(hn::Sub(bits, hn::Set(di, bits_of_root_of_half)));
  const auto mantissa = hn::BitCast(d, hn::Sub(bits, hn::ShiftLeft<23>(exponent)));
  const auto one = hn::Set(d, 1.0f);
  const auto s = hn::Div(hn::Sub(mantissa, one), hn::Add(mantissa, one));
  const auto of_mantissa = hn::Mul(hn::Add(s, s), polynomial(d, hn::Mul(s, s), artanh_series));
  return hn::Add(of_mantissa, hn::Mul(hn::ConvertTo(d, exponent), hn::Set(d, log_of_2)));
}

// e^x of floats up to 80, within 3e-7 of it relatively; x below -87 counts as -87. With x = n log(2) + r and |r| at
// most log(2) / 2, e^r is its Taylor series.
template <class D>
HWY_INLINE hn::VFromD<D> exp_of(D d, hn::VFromD<D> x) {
  constexpr float taylor_series[] = {1.0f, 1.0f, 1.0f / 2, 1.0f / 6, 1.0f / 24, 1.0f / 120, 1.0f / 720, 1.0f / 5040};
  // log(2) in two parts: n times the first is exact.
  constexpr float high_part = 0x1.62ep-1f, low_part = 0x1.0bfbe8p-15f;
  const hn::RebindToSigned<D> di;
  x = hn::Max(x, hn::Set(d, -87.0f));
  const auto n = hn::Round(hn::Mul(x, hn::Set(d, 1 / log_of_2)));
  const auto r = hn::Sub(hn::Sub(x, hn::Mul(n, hn::Set(d, high_part))), hn::Mul(n, hn::Set(d, low_part)));
  const auto power_of_2 = hn::BitCast(d, hn::ShiftLeft<23>(hn::Add(hn::ConvertTo(di, n), hn::Set(di, 127))));
  return hn::Mul(polynomial(d, r, taylor_series), power_of_2);
}

// cos(acos(t) / 3) of doubles from -1 to 1, within 1e-9: in u = sqrt((1 + t) / 2) it is analytic on all of [0, 1], and
// its Chebyshev interpolation of degree 12 in 2 u - 1, written out in powers, is off by 2e-12.
template <class D>
HWY_INLINE hn::VFromD<D> cosine_of_third(D d, hn::VFromD<D> t) {
  constexpr double interpolation[] = {0.7660444431189785,      0.2474090663059609,      -0.015509188431454896,
                                      0.002466353286462045,    -0.0005041248317829706,  0.00011642171253103748,
                                      -2.8918819703486288e-05, 7.553711028844663e-06,   -2.039641478072204e-06,
                                      5.436733079460073e-07,   -1.5342801764116024e-07, 6.130928271047127e-08,
                                      -1.796611461311561e-08};
  const auto one = hn::Set(d, 1.0);
  const auto u = hn::Sqrt(hn::Mul(hn::Set(d, 0.5), hn::Add(one, t)));
  return polynomial(d, hn::Sub(hn::Add(u, u), one), interpolation);
}

}  // namespace facetsort::blend_internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per target
