/* Three-vectors of one precision. vec.h includes this text once for each, with REAL, VEC3, FN(name) and SQRT
 * defined. */

typedef struct VEC3 {
    REAL x, y, z;
} VEC3;

static inline VEC3 FN(vec)(REAL x, REAL y, REAL z) { return (VEC3){x, y, z}; }
static inline VEC3 FN(add)(VEC3 a, VEC3 b) { return (VEC3){a.x + b.x, a.y + b.y, a.z + b.z}; }
static inline VEC3 FN(sub)(VEC3 a, VEC3 b) { return (VEC3){a.x - b.x, a.y - b.y, a.z - b.z}; }
static inline VEC3 FN(neg)(VEC3 a) { return (VEC3){-a.x, -a.y, -a.z}; }
static inline VEC3 FN(scale)(REAL s, VEC3 a) { return (VEC3){s * a.x, s * a.y, s * a.z}; }
/* a + s b */
static inline VEC3 FN(madd)(VEC3 a, REAL s, VEC3 b) {
    return (VEC3){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}
static inline REAL FN(dot)(VEC3 a, VEC3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline VEC3 FN(cross)(VEC3 a, VEC3 b) {
    return (VEC3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/* The length of any finite vector. Components are scaled first, so that squares neither overflow nor
 * underflow. */
static inline REAL FN(length)(VEC3 a) {
    REAL x = a.x < 0 ? -a.x : a.x, y = a.y < 0 ? -a.y : a.y, z = a.z < 0 ? -a.z : a.z;
    REAL big = x > y ? (x > z ? x : z) : (y > z ? y : z);
    if (!(big > 0)) return 0;
    VEC3 s = {a.x / big, a.y / big, a.z / big};
    return big * SQRT(FN(dot)(s, s));
}
/* a / |a|; the zero vector stays zero. */
static inline VEC3 FN(normalize)(VEC3 a) {
    REAL x = a.x < 0 ? -a.x : a.x, y = a.y < 0 ? -a.y : a.y, z = a.z < 0 ? -a.z : a.z;
    REAL big = x > y ? (x > z ? x : z) : (y > z ? y : z);
    if (!(big > 0)) return a;
    VEC3 s = {a.x / big, a.y / big, a.z / big};
    return FN(scale)(1 / SQRT(FN(dot)(s, s)), s);
}
static inline VEC3 FN(load)(const REAL *p) { return (VEC3){p[0], p[1], p[2]}; }
static inline void FN(store)(REAL *p, VEC3 a) { p[0] = a.x, p[1] = a.y, p[2] = a.z; }
