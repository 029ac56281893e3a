// SPDX-License-Identifier: Apache-2.0
#include "collinea/math/tile_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collinea/math/tile_kernels.cc"
#include <hwy/foreach_target.h>

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace collinea::bundle::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Three vectors of rows times four columns stay in registers: 12 sums, 7 loads for 12 products. Element (k, j) of the
// right factor is at k * along + j * across.
template <int kAlong, int kAcross>
HWY_INLINE void Subtract(double* HWY_RESTRICT c, const double* HWY_RESTRICT a, const double* HWY_RESTRICT b,
                         int columns) {
  const hn::CappedTag<double, 8> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  static_assert(kTile % 24 == 0);
  for (int row = 0; row < kTile; row += 3 * lanes) {
    for (int column = 0; column < kTile; column += 4) {
      auto s00 = hn::Zero(d), s10 = s00, s20 = s00, s01 = s00, s11 = s00, s21 = s00;
      auto s02 = s00, s12 = s00, s22 = s00, s03 = s00, s13 = s00, s23 = s00;
      const double* left = a + row;
      const double* right = b + column * kAcross;
      for (int k = 0; k < columns; ++k, left += kTile, right += kAlong) {
        const auto a0 = hn::LoadU(d, left), a1 = hn::LoadU(d, left + lanes), a2 = hn::LoadU(d, left + 2 * lanes);
        const auto b0 = hn::Set(d, right[0]), b1 = hn::Set(d, right[kAcross]);
        s00 = hn::MulAdd(a0, b0, s00), s10 = hn::MulAdd(a1, b0, s10), s20 = hn::MulAdd(a2, b0, s20);
        s01 = hn::MulAdd(a0, b1, s01), s11 = hn::MulAdd(a1, b1, s11), s21 = hn::MulAdd(a2, b1, s21);
        const auto b2 = hn::Set(d, right[2 * kAcross]), b3 = hn::Set(d, right[3 * kAcross]);
        s02 = hn::MulAdd(a0, b2, s02), s12 = hn::MulAdd(a1, b2, s12), s22 = hn::MulAdd(a2, b2, s22);
        s03 = hn::MulAdd(a0, b3, s03), s13 = hn::MulAdd(a1, b3, s13), s23 = hn::MulAdd(a2, b3, s23);
      }
      const auto take = [&](int j, auto s0, auto s1, auto s2) {
        double* out = c + (column + j) * kTile + row;
        hn::StoreU(hn::Sub(hn::LoadU(d, out), s0), d, out);
        hn::StoreU(hn::Sub(hn::LoadU(d, out + lanes), s1), d, out + lanes);
        hn::StoreU(hn::Sub(hn::LoadU(d, out + 2 * lanes), s2), d, out + 2 * lanes);
      };
      take(0, s00, s10, s20);
      take(1, s01, s11, s21);
      take(2, s02, s12, s22);
      take(3, s03, s13, s23);
    }
  }
}

void SubtractProduct(double* HWY_RESTRICT c, const double* HWY_RESTRICT a, const double* HWY_RESTRICT b, int columns) {
  Subtract<kTile, 1>(c, a, b, columns);
}

void SubtractPlainProduct(double* HWY_RESTRICT c, const double* HWY_RESTRICT a, const double* HWY_RESTRICT b) {
  Subtract<1, kTile>(c, a, b, kTile);
}

// Two columns at a time into sums of their own: the chain of additions is half as long.
void SubtractTimes(double* HWY_RESTRICT y, const double* HWY_RESTRICT tile, const double* HWY_RESTRICT x) {
  const hn::CappedTag<double, 8> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int row = 0; row < kTile; row += 3 * lanes) {
    auto s0 = hn::LoadU(d, y + row), s1 = hn::LoadU(d, y + row + lanes), s2 = hn::LoadU(d, y + row + 2 * lanes);
    auto t0 = hn::Zero(d), t1 = t0, t2 = t0;
    const double* values = tile + row;
    for (int c = 0; c < kTile; c += 2, values += 2 * kTile) {
      const auto x0 = hn::Set(d, x[c]), x1 = hn::Set(d, x[c + 1]);
      s0 = hn::NegMulAdd(hn::LoadU(d, values), x0, s0);
      s1 = hn::NegMulAdd(hn::LoadU(d, values + lanes), x0, s1);
      s2 = hn::NegMulAdd(hn::LoadU(d, values + 2 * lanes), x0, s2);
      t0 = hn::MulAdd(hn::LoadU(d, values + kTile), x1, t0);
      t1 = hn::MulAdd(hn::LoadU(d, values + kTile + lanes), x1, t1);
      t2 = hn::MulAdd(hn::LoadU(d, values + kTile + 2 * lanes), x1, t2);
    }
    hn::StoreU(hn::Sub(s0, t0), d, y + row);
    hn::StoreU(hn::Sub(s1, t1), d, y + row + lanes);
    hn::StoreU(hn::Sub(s2, t2), d, y + row + 2 * lanes);
  }
}

void SubtractTransposedTimes(double* HWY_RESTRICT y, const double* HWY_RESTRICT tile, const double* HWY_RESTRICT x) {
  const hn::CappedTag<double, 8> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int row = 0; row < kTile; row += 3 * lanes) {
    const auto x0 = hn::LoadU(d, x + row), x1 = hn::LoadU(d, x + row + lanes), x2 = hn::LoadU(d, x + row + 2 * lanes);
    const double* values = tile + row;
    for (int c = 0; c < kTile; ++c, values += kTile) {
      const auto sum =
          hn::MulAdd(hn::LoadU(d, values), x0,
                     hn::MulAdd(hn::LoadU(d, values + lanes), x1, hn::Mul(hn::LoadU(d, values + 2 * lanes), x2)));
      y[c] -= hn::GetLane(hn::SumOfLanes(d, sum));
    }
  }
}

// Six numbers: a vector of four and one of two, or three of two where there are no longer ones.
#if HWY_TARGET == HWY_SCALAR
struct Six {
  double v[6];
};

HWY_INLINE Six Load(const double* p) { return {{p[0], p[1], p[2], p[3], p[4], p[5]}}; }
HWY_INLINE void Store(const Six& six, double* p) {
  for (int i = 0; i < 6; ++i) p[i] = six.v[i];
}
HWY_INLINE Six Add(const Six& a, double b, Six sum) {
  for (int i = 0; i < 6; ++i) sum.v[i] += a.v[i] * b;
  return sum;
}
HWY_INLINE Six Subtract(const Six& a, double b, const Six& sum) { return Add(a, -b, sum); }
HWY_INLINE Six AddSquare(const Six& a, Six sum) {
  for (int i = 0; i < 6; ++i) sum.v[i] += a.v[i] * a.v[i];
  return sum;
}
#else
#if HWY_MAX_BYTES >= 32
constexpr hn::FixedTag<double, 4> kFirst;
#else
constexpr hn::FixedTag<double, 2> kFirst;
#endif
constexpr hn::FixedTag<double, 2> kLast;
constexpr int kMiddle = HWY_MAX_BYTES >= 32 ? 0 : 2;  // where the second vector begins when there are three

struct Six {
  hn::Vec<decltype(kFirst)> first, middle;  // middle: unused with vectors of four
  hn::Vec<decltype(kLast)> last;
};

HWY_INLINE Six Load(const double* p) {
  return {hn::LoadU(kFirst, p), hn::LoadU(kFirst, p + kMiddle), hn::LoadU(kLast, p + 4)};
}
HWY_INLINE void Store(const Six& v, double* p) {
  if (kMiddle > 0) hn::StoreU(v.middle, kFirst, p + kMiddle);
  hn::StoreU(v.first, kFirst, p);
  hn::StoreU(v.last, kLast, p + 4);
}
HWY_INLINE Six Add(const Six& a, double b, const Six& sum) {
  return {hn::MulAdd(a.first, hn::Set(kFirst, b), sum.first), hn::MulAdd(a.middle, hn::Set(kFirst, b), sum.middle),
          hn::MulAdd(a.last, hn::Set(kLast, b), sum.last)};
}
HWY_INLINE Six Subtract(const Six& a, double b, const Six& sum) {
  return {hn::NegMulAdd(a.first, hn::Set(kFirst, b), sum.first),
          hn::NegMulAdd(a.middle, hn::Set(kFirst, b), sum.middle), hn::NegMulAdd(a.last, hn::Set(kLast, b), sum.last)};
}
HWY_INLINE Six AddSquare(const Six& a, const Six& sum) {
  return {hn::MulAdd(a.first, a.first, sum.first), hn::MulAdd(a.middle, a.middle, sum.middle),
          hn::MulAdd(a.last, a.last, sum.last)};
}
#endif  // HWY_TARGET == HWY_SCALAR

void AddPoseRay(const PoseRay& ray, double* diagonal_block, double* right, double* diagonal, double* const* blocks,
                const PoseRay* partners, int count) {
  const Six j0 = Load(ray.j), j1 = Load(ray.j + 6);
  Store(Add(j1, ray.residual[1], Add(j0, ray.residual[0], Load(right))), right);
  Store(AddSquare(j1, AddSquare(j0, Load(diagonal))), diagonal);
  for (int c = 0; c < 6; ++c) {
    double* out = diagonal_block + c * kTile;
    Store(Add(j1, ray.j[6 + c], Add(j0, ray.j[c], Load(out))), out);
  }
  const Six z0 = Load(ray.z), z1 = Load(ray.z + 6), z2 = Load(ray.z + 12);
  for (int n = 0; n < count; ++n) {
    const double* z = partners[n].z;
    double* out = blocks[n];
    for (int c = 0; c < 6; ++c, out += kTile)
      Store(Subtract(z2, z[12 + c], Subtract(z1, z[6 + c], Subtract(z0, z[c], Load(out)))), out);
  }
}

void AddPoseCamera(double* columns, const PoseRay& ray, const double* b, int count) {
  const Six j0 = Load(ray.j), j1 = Load(ray.j + 6);
  for (int i = 0; i < count; ++i, columns += 6) Store(Add(j1, b[count + i], Add(j0, b[i], Load(columns))), columns);
}

void SubtractPoseCamera(double* columns, const PoseRay& ray, const double* zc, int count) {
  const Six z0 = Load(ray.z), z1 = Load(ray.z + 6), z2 = Load(ray.z + 12);
  for (int i = 0; i < count; ++i, columns += 6, zc += 3)
    Store(Subtract(z2, zc[2], Subtract(z1, zc[1], Subtract(z0, zc[0], Load(columns)))), columns);
}

}  // namespace collinea::bundle::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace collinea::bundle {

HWY_EXPORT(SubtractProduct);
HWY_EXPORT(SubtractPlainProduct);
HWY_EXPORT(SubtractTimes);
HWY_EXPORT(SubtractTransposedTimes);
HWY_EXPORT(AddPoseRay);
HWY_EXPORT(AddPoseCamera);
HWY_EXPORT(SubtractPoseCamera);

void subtract_product(double* c, const double* a, const double* b, int columns) {
  HWY_DYNAMIC_DISPATCH(SubtractProduct)(c, a, b, columns);
}

void subtract_plain_product(double* c, const double* a, const double* b) {
  HWY_DYNAMIC_DISPATCH(SubtractPlainProduct)(c, a, b);
}

void subtract_times(double* y, const double* tile, const double* x) { HWY_DYNAMIC_DISPATCH(SubtractTimes)(y, tile, x); }

void subtract_transposed_times(double* y, const double* tile, const double* x) {
  HWY_DYNAMIC_DISPATCH(SubtractTransposedTimes)(y, tile, x);
}

void add_pose_ray(const PoseRay& ray, double* diagonal_block, double* right, double* diagonal, double* const* blocks,
                  const PoseRay* partners, int count) {
  HWY_DYNAMIC_DISPATCH(AddPoseRay)(ray, diagonal_block, right, diagonal, blocks, partners, count);
}

void add_pose_camera(double* columns, const PoseRay& ray, const double* b, int count) {
  HWY_DYNAMIC_DISPATCH(AddPoseCamera)(columns, ray, b, count);
}

void subtract_pose_camera(double* columns, const PoseRay& ray, const double* zc, int count) {
  HWY_DYNAMIC_DISPATCH(SubtractPoseCamera)(columns, ray, zc, count);
}

}  // namespace collinea::bundle
#endif
