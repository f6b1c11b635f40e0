// Far pairs of triangles for boundary elements, and the product with the matrix that they make. Geometry: N_FIELDS rows of n
// triangles: 0 to 8 points (point, axis), 9 to 11 normal, 12 to 20 curls of the hat functions (corner, axis), 21 area / 3.
// Sums are those of detail/far_kernel.cpp, with the same root and sine: double precision gives the processor's digits.

#ifdef KLANG_DOUBLE
REAL inverse_root(const REAL x) {
  REAL y = as_double(0x5fe6eb50c7b537a9L - (as_long(x) >> 1));
  const REAL half_x = 0.5 * x;
  y *= 1.5 - half_x * y * y;
  y *= 1.5 - half_x * y * y;
  y *= 1.5 - half_x * y * y;
  return y;
}
REAL2 cosine_sine(const REAL x) {
  const REAL turns = rint(x * 0.63661977236758134308);
  const REAL r = (x - turns * 1.5707963267341256) - turns * 6.077100506506192e-11;
  const REAL r2 = r * r;
  const REAL s = r * (1.0 + r2 * (-1.0 / 6 + r2 * (1.0 / 120 + r2 * (-1.0 / 5040 + r2 * (1.0 / 362880 - r2 * (1.0 / 39916800))))));
  const REAL c = 1.0 + r2 * (-0.5 + r2 * (1.0 / 24 + r2 * (-1.0 / 720 + r2 * (1.0 / 40320 + r2 * (-1.0 / 3628800 + r2 * (1.0 / 479001600))))));
  const int quadrant = (int)turns & 3;
  const REAL a = (quadrant & 1) ? c : s, b = (quadrant & 1) ? s : c;
  return (REAL2)(((quadrant + 1) & 2) ? -b : b, (quadrant & 2) ? -a : a);
}
#else
REAL inverse_root(const REAL x) { return rsqrt(x); }
REAL2 cosine_sine(const REAL x) {
  REAL c;
  const REAL s = sincos(x, &c);
  return (REAL2)(c, s);
}
#endif

#define AT(field, triangle) geometry[(size_t)(field) * n + (triangle)]

REAL2 times_complex(const REAL2 a, const REAL2 b) { return (REAL2)(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x); }

bool is_near(__global const uint* near_bits, const int words, const int local_test, const int s) {
  return (near_bits[(size_t)local_test * words + s / 32] >> (s % 32) & 1u) != 0;
}

// One item a pair: -K + i eta N against the hat functions a and b, to pairs[(9 test + 3 a + b) n + s]; near pairs give 0.
__kernel void far_pairs(const int n, __global const REAL* geometry, __global const int* tests, __global const uint* near_bits,
                        const int words, const REAL k, const REAL eta, __global REAL2* pairs) {
  const int s = get_global_id(0), local_test = get_global_id(1);
  if (s >= n) return;
  __global REAL2* out = pairs + (size_t)9 * local_test * n + s;
  if (is_near(near_bits, words, local_test, s)) {
    for (int e = 0; e < 9; ++e) out[(size_t)e * n] = (REAL2)(0, 0);
    return;
  }
  const int t = tests[local_test];
  const REAL nx = AT(9, t), ny = AT(10, t), nz = AT(11, t), mx = AT(9, s), my = AT(10, s), mz = AT(11, s);
  const REAL weight = AT(21, s) * (AT(21, t) / (REAL)12.566370614359172954);
  const REAL mass = eta * k * k * (nx * mx + ny * my + nz * mz);
  REAL2 system[3][3], all = (REAL2)(0, 0);
  for (int i = 0; i < 3; ++i) {
    const REAL x = AT(3 * i, t), y = AT(3 * i + 1, t), z = AT(3 * i + 2, t);
    for (int q = 0; q < 3; ++q) {
      const REAL dx = x - AT(3 * q, s), dy = y - AT(3 * q + 1, s), dz = z - AT(3 * q + 2, s);
      const REAL r_sq = dx * dx + dy * dy + dz * dz, inverse = inverse_root(r_sq), kr = k * (r_sq * inverse);
      const REAL2 wave = cosine_sine(kr);
      const REAL scale = weight * inverse, inverse_sq = inverse * inverse;
      const REAL2 g = (REAL2)(scale * wave.x, -(scale * wave.y));
      const REAL2 h = (REAL2)(g.x - kr * g.y, g.y + kr * g.x) * inverse_sq;
      const REAL m_d = mx * dx + my * dy + mz * dz;
      system[i][q] = (REAL2)(-(h.x * m_d) - mass * g.y, -(h.y * m_d) + mass * g.x);
      all += g;
    }
  }
  for (int i = 0; i < 3; ++i) {
    const REAL2 sum = (system[i][0] + system[i][1] + system[i][2]) / (REAL)6;
    for (int q = 0; q < 3; ++q) system[i][q] = (REAL)0.5 * system[i][q] + sum;
  }
  for (int b = 0; b < 3; ++b) {
    const REAL2 sum = (system[0][b] + system[1][b] + system[2][b]) / (REAL)6;
    const REAL cx = AT(12 + 3 * b, s), cy = AT(13 + 3 * b, s), cz = AT(14 + 3 * b, s);
    for (int a = 0; a < 3; ++a) {
      const REAL stiff = eta * (AT(12 + 3 * a, t) * cx + AT(13 + 3 * a, t) * cy + AT(14 + 3 * a, t) * cz);
      out[(size_t)(3 * a + b) * n] = (REAL)0.5 * system[a][b] + sum + stiff * (REAL2)(all.y, -all.x);
    }
  }
}

// One item an entry of the matrix: the sum over the triangles of its row and of its column. users: 4 local_test + a of a row's
// triangles; corners: 4 s + b of a column's.
__kernel void gathered(const int n, const int n_rows, const int first_row, __global const int* users_at, __global const int* users,
                       __global const int* corners_at, __global const int* corners, __global const REAL* row_scale,
                       __global const REAL2* pairs, __global REAL2* matrix) {
  const int column = get_global_id(0), row = get_global_id(1);
  if (column >= n_rows) return;
  REAL2 sum = (REAL2)(0, 0);
  for (int u = users_at[row]; u < users_at[row + 1]; ++u) {
    __global const REAL2* of_test = pairs + ((size_t)9 * (users[u] / 4) + 3 * (users[u] % 4)) * n;
    for (int c = corners_at[column]; c < corners_at[column + 1]; ++c)
      sum += of_test[(size_t)(corners[c] % 4) * n + corners[c] / 4];
  }
  matrix[(size_t)(first_row + row) * n_rows + column] = row_scale[first_row + row] * sum;
}

// One item a row: what the processor found for near pairs.
__kernel void add_near(const int n_rows, __global const int* entries_at, __global const int* columns, __global const REAL2* values,
                       __global REAL2* matrix) {
  const int row = get_global_id(0);
  if (row >= n_rows) return;
  for (int e = entries_at[row]; e < entries_at[row + 1]; ++e) matrix[(size_t)row * n_rows + columns[e]] += values[e];
}

#define COLUMNS 4

// One group a test triangle: sum of -S + i eta K' against its hat functions for the normal derivative at the points of all far
// triangles, value[(3 c + q) n + s], COLUMNS columns; to right[(3 test + a) COLUMNS + c].
__kernel __attribute__((reqd_work_group_size(GROUP, 1, 1))) void far_right(
    const int n, __global const REAL* geometry, const int first_test, __global const uint* near_bits, const int words, const REAL k,
    const REAL eta, __global const REAL2* value, __global REAL2* right) {
  const int item = get_local_id(0), local_test = get_group_id(0), t = first_test + local_test;
  const REAL nx = AT(9, t), ny = AT(10, t), nz = AT(11, t), weight_t = AT(21, t) / (REAL)12.566370614359172954;
  REAL2 at_point[3][COLUMNS];
  for (int i = 0; i < 3; ++i)
    for (int c = 0; c < COLUMNS; ++c) at_point[i][c] = (REAL2)(0, 0);
  for (int s = item; s < n; s += GROUP) {
    if (is_near(near_bits, words, local_test, s)) continue;
    const REAL weight = AT(21, s) * weight_t;
    for (int q = 0; q < 3; ++q) {
      REAL2 v[COLUMNS];
      for (int c = 0; c < COLUMNS; ++c) v[c] = value[(size_t)(3 * c + q) * n + s];
      for (int i = 0; i < 3; ++i) {
        const REAL dx = AT(3 * i, t) - AT(3 * q, s), dy = AT(3 * i + 1, t) - AT(3 * q + 1, s), dz = AT(3 * i + 2, t) - AT(3 * q + 2, s);
        const REAL r_sq = dx * dx + dy * dy + dz * dz, inverse = inverse_root(r_sq), kr = k * (r_sq * inverse);
        const REAL2 wave = cosine_sine(kr);
        const REAL scale = weight * inverse, inverse_sq = inverse * inverse;
        const REAL2 g = (REAL2)(scale * wave.x, -(scale * wave.y));
        const REAL2 h = (REAL2)(g.x - kr * g.y, g.y + kr * g.x) * inverse_sq;
        const REAL n_d = eta * (nx * dx + ny * dy + nz * dz);
        const REAL2 source = (REAL2)(-g.x + h.y * n_d, -g.y - h.x * n_d);
        for (int c = 0; c < COLUMNS; ++c) at_point[i][c] += times_complex(source, v[c]);
      }
    }
  }
  __local REAL2 sums[GROUP];
  for (int i = 0; i < 3; ++i)
    for (int c = 0; c < COLUMNS; ++c) {
      barrier(CLK_LOCAL_MEM_FENCE);
      sums[item] = at_point[i][c];
      for (int half_size = GROUP / 2; half_size > 0; half_size /= 2) {
        barrier(CLK_LOCAL_MEM_FENCE);
        if (item < half_size) sums[item] += sums[item + half_size];
      }
      if (item == 0) right[((size_t)3 * t + i) * COLUMNS + c] = sums[0];
    }
}

// One group a row: matrix x for COLUMNS columns of n_rows numbers each.
__kernel __attribute__((reqd_work_group_size(GROUP, 1, 1))) void product(const int n_rows, __global const REAL2* matrix,
                                                                          __global const REAL2* x, __global REAL2* y) {
  const int item = get_local_id(0), row = get_group_id(0);
  __global const REAL2* of_row = matrix + (size_t)row * n_rows;
  REAL2 sum[COLUMNS];
  for (int c = 0; c < COLUMNS; ++c) sum[c] = (REAL2)(0, 0);
  for (int j = item; j < n_rows; j += GROUP) {
    const REAL2 a = of_row[j];
    for (int c = 0; c < COLUMNS; ++c) sum[c] += times_complex(a, x[(size_t)c * n_rows + j]);
  }
  __local REAL2 sums[GROUP];
  for (int c = 0; c < COLUMNS; ++c) {
    barrier(CLK_LOCAL_MEM_FENCE);
    sums[item] = sum[c];
    for (int half_size = GROUP / 2; half_size > 0; half_size /= 2) {
      barrier(CLK_LOCAL_MEM_FENCE);
      if (item < half_size) sums[item] += sums[item + half_size];
    }
    if (item == 0) y[(size_t)c * n_rows + row] = sums[0];
  }
}
