// All-mode acoustic transfer in the passes of SB section 4. REAL is float or double, GROUP the size of a reduction (Session).
// Listeners are the last dimension of every pass; a "slot" is one pair of centre and listener.

// Numbers in two parts, high + low: single precision alone would lose the phase at large kr, and powers and recurrences of
// high order would magnify the rounding of their factor.
REAL2 product_of(const REAL2 a, const REAL2 b) {
  const REAL p = a.x * b.x;
  return (REAL2)(p, fma(a.x, b.x, -p) + (a.x * b.y + a.y * b.x));
}
REAL2 difference_of(const REAL2 a, const REAL2 b) {
  const REAL s = a.x - b.x, back = s - a.x;
  return (REAL2)(s, (a.x - (s - back)) - (b.x + back) + (a.y - b.y));
}
REAL2 sum_of(const REAL2 a, const REAL2 b) { return difference_of(a, -b); }

// Pass 1, one item a mode and listener: h_n^(2)(kr), n = 0 ... order, by the upward recurrence.
__kernel void hankel(__global const int* order, __global const int* centre_of_mode, __global const int* first_degree,
                     const int n_degrees, const int n_centres, const REAL two_pi_high, const REAL two_pi_low,
                     __global const REAL2* turns_per_m, __global const REAL2* distance_m, __global REAL2* h) {
  const int mode = get_global_id(0), listener = get_global_id(1);
  const REAL2 turns = product_of(turns_per_m[mode], distance_m[listener * n_centres + centre_of_mode[mode]]);
  REAL c;
  const REAL s = sincos(two_pi_high * ((turns.x - rint(turns.x)) + turns.y), &c);
  const REAL2 x = product_of(turns, (REAL2)(two_pi_high, two_pi_low));
  const REAL inverse = 1 / x.x;
  const REAL inverse_low = inverse * (fma(-x.x, inverse, (REAL)1) - x.y * inverse);
  REAL2 now = (REAL2)(s, c) * inverse;     // h_0 = i e^{-ix} / x
  REAL2 before = (REAL2)(now.y, -now.x);   // h_{-1} = -i h_0
  __global REAL2* out = h + (size_t)listener * n_degrees + first_degree[mode];
  const int n_max = order[mode];
  for (int n = 0; n <= n_max; ++n) {
    out[n] = now;
    const REAL2 odd = (REAL)(2 * n + 1) * now;
    const REAL2 next = fma(odd, (REAL2)(inverse), fma(odd, (REAL2)(inverse_low), -before));
    before = now;
    now = next;
  }
}

// Pass 2, one item a slot: Y_m^m = d_m (s_x + i s_y)^m, m = 0 ... order. sectoral: largest_order + 1 values a slot.
__kernel void sectoral_harmonics(__global const int* order_of_centre, const int n_centres, const int largest_order,
                                 __global const REAL* diagonal, __global const REAL2* direction, __global REAL2* sectoral) {
  const int centre = get_global_id(0), listener = get_global_id(1);
  const int slot = listener * n_centres + centre;
  const REAL2 x = direction[3 * slot], y = direction[3 * slot + 1];
  __global REAL2* out = sectoral + (size_t)slot * (largest_order + 1);
  REAL2 re = (REAL2)(1, 0), im = (REAL2)(0, 0);
  for (int m = 0; m <= order_of_centre[centre]; ++m) {
    out[m] = diagonal[m] * (REAL2)(re.x + re.y, im.x + im.y);
    const REAL2 next = difference_of(product_of(re, x), product_of(im, y));
    im = sum_of(product_of(re, y), product_of(im, x));
    re = next;
  }
}

// Pass 3, one item a slot and m: Y_n^m, n = m ... order, from Y_{n-1}^m and Y_{n-2}^m. Real harmonics: Re Y_n^m at
// n (n + 1) + m, Im Y_n^m at n (n + 1) - m. Near the poles the recurrence magnifies rounding n-fold: in single precision it
// runs in two parts.
__kernel void harmonics(__global const int* order_of_centre, __global const int* first_harmonic, const int n_harmonics,
                        const int n_centres, const int largest_order, __global const REAL2* by_z, __global const REAL2* by_previous,
                        __global const REAL2* direction, __global const REAL2* sectoral, __global REAL* y) {
  const int m = get_global_id(0), centre = get_global_id(1), listener = get_global_id(2);
  const int order = order_of_centre[centre];
  if (m > order) return;
  const int slot = listener * n_centres + centre;
  const REAL2 z = direction[3 * slot + 2];
  __global REAL* out = y + (size_t)listener * n_harmonics + first_harmonic[centre];
  const REAL2 first = sectoral[(size_t)slot * (largest_order + 1) + m];
  REAL2 before = (REAL2)(0, 0), now = (REAL2)(1, 0);  // Y_n^m / Y_m^m, high + low
  for (int n = m; n <= order; ++n) {
    if (n > m) {
      const int i = n * (n + 1) / 2 + m;
#ifdef KLANG_DOUBLE
      const REAL2 next = (REAL2)(by_z[i].x * z.x * now.x - by_previous[i].x * before.x, 0);
#else
      const REAL2 next = difference_of(product_of(product_of(by_z[i], z), now), product_of(by_previous[i], before));
#endif
      before = now;
      now = next;
    }
    const int at = n * (n + 1);
    const REAL ratio = now.x + now.y;
    out[at + m] = ratio * first.x;
    if (m > 0) out[at - m] = ratio * first.y;
  }
}

// Pass 4, one group a mode and listener: p = sum_n h_n sum_j c_nj y_nj by a tree.
__kernel __attribute__((reqd_work_group_size(GROUP, 1, 1))) void reduction(
    __global const int* order, __global const int* centre_of_mode, __global const int* first_degree, __global const int* first_harmonic,
    __global const int* first_coefficient, __global const int* degree, const int n_degrees, const int n_harmonics, const int n_modes,
    __global const REAL2* coefficients, __global const REAL2* h, __global const REAL* y, __global REAL2* p) {
  const int item = get_local_id(0), mode = get_group_id(0), listener = get_global_id(1);
  const int size = (order[mode] + 1) * (order[mode] + 1);
  __global const REAL2* c = coefficients + first_coefficient[mode];
  __global const REAL2* hankel_n = h + (size_t)listener * n_degrees + first_degree[mode];
  __global const REAL* harmonic = y + (size_t)listener * n_harmonics + first_harmonic[centre_of_mode[mode]];
  REAL2 sum = (REAL2)(0, 0);
  for (int i = item; i < size; i += GROUP) {
    const REAL2 f = hankel_n[degree[i]], v = c[i] * harmonic[i];
    sum += (REAL2)(f.x * v.x - f.y * v.y, f.x * v.y + f.y * v.x);
  }
  __local REAL2 sums[GROUP];
  sums[item] = sum;
  for (int half_size = GROUP / 2; half_size > 0; half_size /= 2) {
    barrier(CLK_LOCAL_MEM_FENCE);
    if (item < half_size) sums[item] += sums[item + half_size];
  }
  if (item == 0) p[(size_t)listener * n_modes + mode] = sums[0];
}
