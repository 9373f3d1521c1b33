"""Warp kernels of the layered shell: energy, gradient and Hessian of a triangle mesh.

Everything is in double precision, lengths in mm, energies divided by the reference shear modulus mu [mm^3].
Several worlds, films of one mesh, lie in the arrays one after another, unconnected; a launch works on some of them.
One triangle T with vertices q0, q1, q2 carries the first fundamental form a and the second form b from mid-edge
normals, both pulled back to an orthonormal frame of the flat film. Symmetric 2x2 tensors are stored as (11, 12, 22).

Energy per flat area (incompressible neo-classical trace form, `Film` gives A_q, z_q and the weights):

    W = sum_q w_q/2 ( tr(A_q^-1 G(z_q)) + det A_q / det G(z_q) - 3 ),   G(z) = a - 2 z b + z^2 b a^-1 b.

With D = det a, N = D tr(a^-1 b), B = det b, Cayley-Hamilton gives b a^-1 b = (N b - B a) / D and
det G = (D - z N + z^2 B)^2 / D, so that with the moments M_j = sum_q w_q/2 z_q^j A_q^-1 and c_q = w_q/2 det A_q

    W = M0:a - 2 M1:b + (N M2:b - B M2:a) / D + sum_q c_q D / (D - z_q N + z_q^2 B)^2 - 3/2 sum_q w_q.

All second derivatives are then short. Unit normals vary as dm = -sum_k grad(phi_k) (m . dq_k) with the hat
functions phi_k of the deformed triangle, which makes the exact Hessian of b short too.
"""

import warp as wp

wp.set_module_options({"enable_backward": False})

vec5 = wp.types.vector(length=5, dtype=wp.float64)
vec6 = wp.types.vector(length=6, dtype=wp.float64)
mat66 = wp.types.matrix(shape=(6, 6), dtype=wp.float64)
mat63 = wp.types.matrix(shape=(6, 3), dtype=wp.float64)
vec3 = wp.vec3d
mat33 = wp.mat33d

ZERO = wp.constant(wp.float64(0.0))
HALF = wp.constant(wp.float64(0.5))
ONE = wp.constant(wp.float64(1.0))
TWO = wp.constant(wp.float64(2.0))
FOUR = wp.constant(wp.float64(4.0))
SIX = wp.constant(wp.float64(6.0))
INFINITE = wp.constant(wp.float64(1.0e300))


@wp.struct
class Topology:
    """Constant data of the mesh; local vertices 0, 1, 2 are the triangle's own, 3 + i lies across edge i."""

    stencil: wp.array2d(dtype=wp.int32)
    """Vertex of each local slot, -1 across a boundary edge, shape [T, 6]; edge i is opposite vertex i."""
    across: wp.array2d(dtype=wp.int32)
    """Triangle across edge i, -1 at the boundary, shape [T, 3]."""
    across_slot: wp.array2d(dtype=wp.int32)
    """Local slot (0..2) in that triangle of its vertex off the edge, shape [T, 3]."""
    frame: wp.array(dtype=wp.mat22d)
    """Inverse of the flat edge matrix [e1 e2] [1/mm], shape [T]."""
    area: wp.array(dtype=wp.float64)
    """Flat area [mm^2], shape [T]."""


@wp.struct
class Rest:
    """What the layers prescribe at the present temperature."""

    moments: wp.array(dtype=wp.mat33d)
    """Rows M0, M1, M2 as weights of (11, 12, 22), off-diagonal doubled, shape [T]."""
    point_z: wp.array2d(dtype=wp.float64)
    """Heights z_q [mm], shape [T, Q]."""
    point_c: wp.array2d(dtype=wp.float64)
    """w_q/2 det A_q [mm], shape [T, Q]."""
    constant: wp.array(dtype=wp.float64)
    """3/2 sum_q w_q [mm], shape [T]."""


@wp.struct
class Geometry:
    """Deformed triangles: what the kernels of one evaluation share."""

    normal: wp.array(dtype=wp.vec3d)
    """Unit normal, shape [T]."""
    hat: wp.array2d(dtype=wp.vec3d)
    """Gradient of the hat function of each own vertex [1/mm], shape [T, 3]."""


@wp.struct
class Response:
    """First and second derivatives of a triangle's energy with respect to (a, b), and of (a, b) to its vertices."""

    stress: wp.array(dtype=vec6)
    """Area times dW/d(a, b), shape [T]."""
    stiffness: wp.array(dtype=mat66)
    """Area times d2W/d(a, b)^2, shape [T]."""
    strain: wp.array2d(dtype=mat63)
    """d(a, b)/dq of each of the six stencil vertices, shape [T, 6]."""


@wp.struct
class Bending:
    """What the blocks of a triangle's bending stiffness share, for edge i and its slots j, see `slot_vertex`."""

    edge: wp.array2d(dtype=vec3)
    """1 / |s| [1], w.n along the mid-edge normal, and what is left of w along the own normal, shape [T, 3]."""
    slot: wp.array2d(dtype=vec5)
    """n.g, n.g', p.g, p.g' with what is left of w, p, and dw/dq: its coefficient of the identity, shape [T, 12]."""


@wp.func
def place_of(item: int, worlds: wp.array(dtype=wp.int32), each: int) -> int:
    """Place of an item of a launch over some worlds, which have `each` items one after another."""
    return worlds[item / each] * each + item % each


@wp.func
def pull_back(edge_form: vec3, t: wp.mat22d) -> vec3:
    """Express a form given on the edge vectors in the orthonormal frame: T^t I T."""
    return vec3(
        t[0, 0] * t[0, 0] * edge_form[0] + TWO * t[0, 0] * t[1, 0] * edge_form[1] + t[1, 0] * t[1, 0] * edge_form[2],
        t[0, 0] * t[0, 1] * edge_form[0]
        + (t[0, 0] * t[1, 1] + t[1, 0] * t[0, 1]) * edge_form[1]
        + t[1, 0] * t[1, 1] * edge_form[2],
        t[0, 1] * t[0, 1] * edge_form[0] + TWO * t[0, 1] * t[1, 1] * edge_form[1] + t[1, 1] * t[1, 1] * edge_form[2],
    )


@wp.func
def push_to_edges(stress: vec3, t: wp.mat22d) -> vec3:
    """Transpose of `pull_back`: derivatives with respect to the edge form from those in the frame."""
    return vec3(
        t[0, 0] * t[0, 0] * stress[0] + t[0, 0] * t[0, 1] * stress[1] + t[0, 1] * t[0, 1] * stress[2],
        TWO * t[0, 0] * t[1, 0] * stress[0]
        + (t[0, 0] * t[1, 1] + t[1, 0] * t[0, 1]) * stress[1]
        + TWO * t[0, 1] * t[1, 1] * stress[2],
        t[1, 0] * t[1, 0] * stress[0] + t[1, 0] * t[1, 1] * stress[1] + t[1, 1] * t[1, 1] * stress[2],
    )


@wp.func
def edge_normal_sum(topology: Topology, normal: wp.array(dtype=wp.vec3d), t: int, i: int) -> vec3:
    """Sum of the unit normals on both sides of edge i (twice the own normal at the boundary)."""
    other = topology.across[t, i]
    if other < 0:
        return TWO * normal[t]
    return normal[t] + normal[other]


@wp.func
def hat_across(topology: Topology, geometry: Geometry, t: int, i: int, k: int) -> vec3:
    """Hat gradient of stencil vertex k in the triangle across edge i (zero if it is not one of its vertices)."""
    other = topology.across[t, i]
    slot = topology.across_slot[t, i]
    if k == 3 + i:
        return geometry.hat[other, slot]
    if k == (i + 2) % 3:
        return geometry.hat[other, (slot + 1) % 3]
    if k == (i + 1) % 3:
        return geometry.hat[other, (slot + 2) % 3]
    return vec3()


@wp.func
def hat_own(geometry: Geometry, t: int, k: int) -> vec3:
    """Hat gradient of stencil vertex k in triangle t itself."""
    if k < 3:
        return geometry.hat[t, k]
    return vec3()


@wp.kernel
def triangle_geometry(
    topology: Topology,
    q: wp.array(dtype=wp.vec3d),
    worlds: wp.array(dtype=wp.int32),
    each: int,
    first: int,
    geometry: Geometry,
):
    """Write the unit normal and the hat gradients of each deformed triangle."""
    t = place_of(first + wp.tid(), worlds, each)
    q0 = q[topology.stencil[t, 0]]
    q1 = q[topology.stencil[t, 1]]
    q2 = q[topology.stencil[t, 2]]
    n = wp.cross(q1 - q0, q2 - q0)
    twice_area = wp.length(n)
    m = n / twice_area
    geometry.normal[t] = m
    geometry.hat[t, 0] = wp.cross(m, q2 - q1) / twice_area
    geometry.hat[t, 1] = wp.cross(m, q0 - q2) / twice_area
    geometry.hat[t, 2] = wp.cross(m, q1 - q0) / twice_area


@wp.func
def first_form(e1: vec3, e2: vec3) -> vec3:
    """Return (e1.e1, e1.e2, e2.e2)."""
    return vec3(wp.dot(e1, e1), wp.dot(e1, e2), wp.dot(e2, e2))


@wp.func
def second_form(n0: vec3, n1: vec3, n2: vec3, e1: vec3, e2: vec3) -> vec3:
    """Second fundamental form on the edge vectors from the three mid-edge normals."""
    b12 = -TWO * wp.dot(n0, e1)
    return vec3(b12 + TWO * wp.dot(n1, e1), b12, TWO * (wp.dot(n2, e2) - wp.dot(n0, e2)))


@wp.func
def det3(s: vec3) -> wp.float64:
    """Determinant of a symmetric 2x2 tensor (11, 12, 22)."""
    return s[0] * s[2] - s[1] * s[1]


@wp.kernel
def triangle_energy(
    topology: Topology,
    rest: Rest,
    q: wp.array(dtype=wp.vec3d),
    geometry: Geometry,
    worlds: wp.array(dtype=wp.int32),
    each: int,
    first: int,
    energy: wp.array(dtype=wp.float64),
):
    """Write area * W of each triangle; a film folded through its own thickness has infinite energy."""
    t = place_of(first + wp.tid(), worlds, each)
    q0 = q[topology.stencil[t, 0]]
    e1 = q[topology.stencil[t, 1]] - q0
    e2 = q[topology.stencil[t, 2]] - q0
    n0 = wp.normalize(edge_normal_sum(topology, geometry.normal, t, 0))
    n1 = wp.normalize(edge_normal_sum(topology, geometry.normal, t, 1))
    n2 = wp.normalize(edge_normal_sum(topology, geometry.normal, t, 2))
    a = pull_back(first_form(e1, e2), topology.frame[t])
    b = pull_back(second_form(n0, n1, n2, e1, e2), topology.frame[t])
    m = rest.moments[t]
    D = det3(a)
    N = a[2] * b[0] + a[0] * b[2] - TWO * a[1] * b[1]
    B = det3(b)
    m2 = m[2]
    w = wp.dot(m[0], a) - TWO * wp.dot(m[1], b) + (N * wp.dot(m2, b) - B * wp.dot(m2, a)) / D - rest.constant[t]
    folded = wp.bool(False)
    for p in range(rest.point_z.shape[1]):
        z = rest.point_z[t, p]
        r = D - z * N + z * z * B
        if r <= ZERO:
            folded = True
        w += rest.point_c[t, p] * D / (r * r)
    if folded:
        w = INFINITE
    energy[t] = topology.area[t] * w


@wp.func
def outer_add(h: mat66, u: vec6, v: vec6, s: wp.float64) -> mat66:
    """Return h + s (u v^t + v u^t) / 2."""
    return h + (HALF * s) * (wp.outer(u, v) + wp.outer(v, u))


@wp.func
def clamp_eigenvalues(h: mat66, sweeps: int) -> mat66:
    """Nearest positive semi-definite matrix: negative eigenvalues set to zero (cyclic Jacobi)."""
    d = h
    v = wp.identity(n=6, dtype=wp.float64)
    for _sweep in range(sweeps):
        for i in range(5):
            for j in range(i + 1, 6):
                off = d[i, j]
                if wp.abs(off) > wp.float64(1.0e-14) * (wp.abs(d[i, i]) + wp.abs(d[j, j])):
                    tau = (d[j, j] - d[i, i]) / (TWO * off)
                    tangent = ONE / (wp.abs(tau) + wp.sqrt(ONE + tau * tau))
                    if tau < ZERO:
                        tangent = -tangent
                    c = ONE / wp.sqrt(ONE + tangent * tangent)
                    s = tangent * c
                    for k in range(6):
                        x = d[k, i]
                        y = d[k, j]
                        d[k, i] = c * x - s * y
                        d[k, j] = s * x + c * y
                    for k in range(6):
                        x = d[i, k]
                        y = d[j, k]
                        d[i, k] = c * x - s * y
                        d[j, k] = s * x + c * y
                    for k in range(6):
                        x = v[k, i]
                        y = v[k, j]
                        v[k, i] = c * x - s * y
                        v[k, j] = s * x + c * y
    result = mat66()
    for i in range(6):
        value = d[i, i]
        if value > ZERO:
            for j in range(6):
                for k in range(6):
                    result[j, k] = result[j, k] + value * v[j, i] * v[k, i]
    return result


@wp.kernel
def triangle_response(
    topology: Topology,
    rest: Rest,
    q: wp.array(dtype=wp.vec3d),
    geometry: Geometry,
    second_order: int,
    clamp: int,
    worlds: wp.array(dtype=wp.int32),
    each: int,
    first: int,
    response: Response,
):
    """Write stress, stiffness (clamped to positive semi-definite if asked) and strain derivatives."""
    t = place_of(first + wp.tid(), worlds, each)
    frame = topology.frame[t]
    q0 = q[topology.stencil[t, 0]]
    e1 = q[topology.stencil[t, 1]] - q0
    e2 = q[topology.stencil[t, 2]] - q0
    s0 = edge_normal_sum(topology, geometry.normal, t, 0)
    s1 = edge_normal_sum(topology, geometry.normal, t, 1)
    s2 = edge_normal_sum(topology, geometry.normal, t, 2)
    n0 = wp.normalize(s0)
    n1 = wp.normalize(s1)
    n2 = wp.normalize(s2)
    a = pull_back(first_form(e1, e2), frame)
    b = pull_back(second_form(n0, n1, n2, e1, e2), frame)

    m = rest.moments[t]
    m2 = m[2]
    D = det3(a)
    N = a[2] * b[0] + a[0] * b[2] - TWO * a[1] * b[1]
    B = det3(b)
    alpha = wp.dot(m2, a)
    beta = wp.dot(m2, b)
    X = N * beta - B * alpha
    fD = -X / (D * D)
    fN = beta / D
    fB = -alpha / D
    fDD = TWO * X / (D * D * D)
    fDN = -beta / (D * D)
    fDB = alpha / (D * D)
    fNN = ZERO
    fNB = ZERO
    fBB = ZERO
    for p in range(rest.point_z.shape[1]):
        z = rest.point_z[t, p]
        c = rest.point_c[t, p]
        r = ONE / (D - z * N + z * z * B)
        r2 = c * r * r
        r3 = r2 * r
        r4 = SIX * D * r3 * r
        fD += r2 - TWO * D * r3
        fN += TWO * D * z * r3
        fB -= TWO * D * z * z * r3
        fDD += r4 - FOUR * r3
        fDN += z * (TWO * r3 - r4)
        fDB += z * z * (r4 - TWO * r3)
        fNN += z * z * r4
        fNB -= z * z * z * r4
        fBB += z * z * z * z * r4

    gD = vec6(a[2], -TWO * a[1], a[0], ZERO, ZERO, ZERO)
    gN = vec6(b[2], -TWO * b[1], b[0], a[2], -TWO * a[1], a[0])
    gB = vec6(ZERO, ZERO, ZERO, b[2], -TWO * b[1], b[0])
    gA = vec6(m2[0], m2[1], m2[2], ZERO, ZERO, ZERO)
    gT = vec6(ZERO, ZERO, ZERO, m2[0], m2[1], m2[2])
    linear = vec6(m[0, 0], m[0, 1], m[0, 2], -TWO * m[1, 0], -TWO * m[1, 1], -TWO * m[1, 2])
    area = topology.area[t]
    response.stress[t] = area * (linear + fD * gD + fN * gN + fB * gB + (N / D) * gT - (B / D) * gA)

    if second_order == 1:
        h = mat66()
        h = outer_add(h, gD, gD, fDD)
        h = outer_add(h, gN, gN, fNN)
        h = outer_add(h, gB, gB, fBB)
        h = outer_add(h, gD, gN, TWO * fDN)
        h = outer_add(h, gD, gB, TWO * fDB)
        h = outer_add(h, gN, gB, TWO * fNB)
        h = outer_add(h, gD, gA, TWO * B / (D * D))
        h = outer_add(h, gD, gT, -TWO * N / (D * D))
        h = outer_add(h, gN, gT, TWO / D)
        h = outer_add(h, gB, gA, -TWO / D)
        h[0, 2] = h[0, 2] + fD
        h[2, 0] = h[2, 0] + fD
        h[1, 1] = h[1, 1] - TWO * fD
        h[3, 5] = h[3, 5] + fB
        h[5, 3] = h[5, 3] + fB
        h[4, 4] = h[4, 4] - TWO * fB
        h[2, 3] = h[2, 3] + fN
        h[3, 2] = h[3, 2] + fN
        h[0, 5] = h[0, 5] + fN
        h[5, 0] = h[5, 0] + fN
        h[1, 4] = h[1, 4] - TWO * fN
        h[4, 1] = h[4, 1] - TWO * fN
        if clamp == 1:
            h = clamp_eigenvalues(h, 5)
        response.stiffness[t] = area * h

    # derivatives of the mid-edge normals' products: w.n_i varies as u.(dm + dm_i), u = (w - (w.n) n) / |s|
    i0 = ONE / wp.length(s0)
    i1 = ONE / wp.length(s1)
    i2 = ONE / wp.length(s2)
    u0_e1 = (e1 - wp.dot(e1, n0) * n0) * i0
    u0_e2 = (e2 - wp.dot(e2, n0) * n0) * i0
    u1_e1 = (e1 - wp.dot(e1, n1) * n1) * i1
    u2_e2 = (e2 - wp.dot(e2, n2) * n2) * i2
    own = geometry.normal[t]
    for k in range(6):
        # rows of d(e1.e1, e1.e2, e2.e2)/dq_k and of d(b11, b12, b22)/dq_k on the edge vectors
        a11 = vec3()
        a12 = vec3()
        a22 = vec3()
        b11 = vec3()
        b12 = vec3()
        b22 = vec3()
        if topology.stencil[t, k] >= 0:
            if k == 0:
                a11 = -TWO * e1
                a12 = -(e1 + e2)
                a22 = -TWO * e2
                b12 = TWO * n0
                b11 = TWO * (n0 - n1)
                b22 = TWO * (n0 - n2)
            if k == 1:
                a11 = TWO * e1
                a12 = e2
                b12 = -TWO * n0
                b11 = TWO * (n1 - n0)
            if k == 2:
                a12 = e1
                a22 = TWO * e2
                b22 = TWO * (n2 - n0)
            g = hat_own(geometry, t, k)
            d01 = -wp.dot(u0_e1, g) * own
            d02 = -wp.dot(u0_e2, g) * own
            d11 = -wp.dot(u1_e1, g) * own
            d22 = -wp.dot(u2_e2, g) * own
            if topology.across[t, 0] >= 0:
                g = hat_across(topology, geometry, t, 0, k)
                d01 -= wp.dot(u0_e1, g) * geometry.normal[topology.across[t, 0]]
                d02 -= wp.dot(u0_e2, g) * geometry.normal[topology.across[t, 0]]
            else:
                d01 = TWO * d01
                d02 = TWO * d02
            if topology.across[t, 1] >= 0:
                g = hat_across(topology, geometry, t, 1, k)
                d11 -= wp.dot(u1_e1, g) * geometry.normal[topology.across[t, 1]]
            else:
                d11 = TWO * d11
            if topology.across[t, 2] >= 0:
                g = hat_across(topology, geometry, t, 2, k)
                d22 -= wp.dot(u2_e2, g) * geometry.normal[topology.across[t, 2]]
            else:
                d22 = TWO * d22
            b12 -= TWO * d01
            b11 += TWO * (d11 - d01)
            b22 += TWO * (d22 - d02)
        strain = mat63()
        for c in range(3):
            ra = pull_back(vec3(a11[c], a12[c], a22[c]), frame)
            rb = pull_back(vec3(b11[c], b12[c], b22[c]), frame)
            for r in range(3):
                strain[r, c] = ra[r]
                strain[r + 3, c] = rb[r]
        response.strain[t, k] = strain


@wp.kernel
def vertex_gradient(
    response: Response,
    start: wp.array(dtype=wp.int32),
    triangle: wp.array(dtype=wp.int32),
    slot: wp.array(dtype=wp.int32),
    worlds: wp.array(dtype=wp.int32),
    each: int,
    first: int,
    gradient: wp.array(dtype=wp.vec3d),
):
    """Gather dE/dq of each vertex from the triangles whose stencil it belongs to (no atomics: same sum each time)."""
    v = place_of(first + wp.tid(), worlds, each)
    g = vec3()
    for i in range(start[v], start[v + 1]):
        t = triangle[i]
        g += wp.transpose(response.strain[t, slot[i]]) * response.stress[t]
    gradient[v] = g


@wp.func
def membrane_geometric(topology: Topology, stress: vec6, t: int, k: int, l: int, clamp: int) -> wp.float64:
    """Coefficient of the identity in sum_ij sigma_ij d2 a_ij / dq_k dq_l; stress clamped to tension if asked."""
    if k > 2 or l > 2:
        return ZERO
    s11 = stress[0]
    s12 = HALF * stress[1]
    s22 = stress[2]
    if clamp == 1:
        mean = HALF * (s11 + s22)
        radius = wp.sqrt(HALF * HALF * (s11 - s22) * (s11 - s22) + s12 * s12)
        low = mean - radius
        if mean + radius <= ZERO:
            return ZERO
        if low < ZERO:
            # keep only the tensile principal stress p: p (I + S/radius)/2 with S the deviator
            p = HALF * (mean + radius)
            d11 = HALF * (s11 - s22) / radius
            d12 = s12 / radius
            s11 = p * (ONE + d11)
            s22 = p * (ONE - d11)
            s12 = p * d12
    edge = push_to_edges(vec3(s11, TWO * s12, s22), topology.frame[t])
    c11 = TWO * edge[0]
    c12 = edge[1]
    c22 = TWO * edge[2]
    k1 = ZERO
    k2 = ZERO
    l1 = ZERO
    l2 = ZERO
    if k == 0:
        k1 = -ONE
        k2 = -ONE
    if k == 1:
        k1 = ONE
    if k == 2:
        k2 = ONE
    if l == 0:
        l1 = -ONE
        l2 = -ONE
    if l == 1:
        l1 = ONE
    if l == 2:
        l2 = ONE
    return c11 * k1 * l1 + c12 * (k1 * l2 + k2 * l1) + c22 * k2 * l2


@wp.func
def slot_vertex(i: int, j: int) -> int:
    """Stencil vertex of slot j (0..3) of edge i: the triangle's own three, then the one across."""
    if j < 3:
        return j
    return 3 + i


@wp.kernel
def edge_bending(
    topology: Topology,
    geometry: Geometry,
    response: Response,
    q: wp.array(dtype=wp.vec3d),
    worlds: wp.array(dtype=wp.int32),
    each: int,
    first: int,
    bending: Bending,
):
    """Write what all blocks of a triangle share in the second derivatives of its mid-edge normals.

    With s = m + m' the sum of the normals on both sides of edge i, n = s / |s| and w_i = d(stress.b)/dn_i; at the
    boundary n = m.
    """
    t = place_of(first + wp.tid(), worlds, each)
    q0 = q[topology.stencil[t, 0]]
    e1 = q[topology.stencil[t, 1]] - q0
    e2 = q[topology.stencil[t, 2]] - q0
    own = geometry.normal[t]
    stress = response.stress[t]
    bend = push_to_edges(vec3(stress[3], stress[4], stress[5]), topology.frame[t])
    for i in range(3):
        # w_i = c1 e1 + c2 e2
        c1 = ZERO
        c2 = ZERO
        if i == 0:
            c1 = -TWO * (bend[0] + bend[1])
            c2 = -TWO * bend[2]
        if i == 1:
            c1 = TWO * bend[0]
        if i == 2:
            c2 = TWO * bend[2]
        w = c1 * e1 + c2 * e2
        other = topology.across[t, i]
        n = vec3()
        across = w
        inverse = ONE
        along = ZERO
        if other >= 0:
            s = own + geometry.normal[other]
            inverse = ONE / wp.length(s)
            n = s * inverse
            along = wp.dot(w, n)
            across = w - along * n
        bending.edge[t, i] = vec3(inverse, along, wp.dot(across, own))
        for j in range(4):
            k = slot_vertex(i, j)
            g = hat_own(geometry, t, k)
            o = vec3()
            if other >= 0:
                o = hat_across(topology, geometry, t, i, k)
            c = ZERO
            if j == 0:
                c = -(c1 + c2)
            if j == 1:
                c = c1
            if j == 2:
                c = c2
            bending.slot[t, 4 * i + j] = vec5(wp.dot(n, g), wp.dot(n, o), wp.dot(across, g), wp.dot(across, o), c)


@wp.func
def bending_geometric(topology: Topology, geometry: Geometry, bending: Bending, t: int, k: int, l: int) -> mat33:
    """Block (k, l) of sum_j stress_j d2 b_j / dq dq, where sum_j stress_j b_j = sum_i w_i . n_i.

    All of it are outer products with the two normals m and m' at each edge, as dn_i = P ds / |s| and
    ds/dq_k = -(g_k m^t + g'_k m'^t) with the hat gradients g and g' of both triangles.
    """
    own = geometry.normal[t]
    gk = hat_own(geometry, t, k)
    gl = hat_own(geometry, t, l)
    h = mat33()
    for i in range(3):
        if (k < 3 or k == 3 + i) and (l < 3 or l == 3 + i):
            other = topology.across[t, i]
            mo = vec3()
            ok = vec3()
            ol = vec3()
            if other >= 0:
                mo = geometry.normal[other]
                ok = hat_across(topology, geometry, t, i, k)
                ol = hat_across(topology, geometry, t, i, l)
            edge = bending.edge[t, i]
            inverse = edge[0]
            along = edge[1]
            tilt = inverse * edge[2]
            x = bending.slot[t, 4 * i + wp.min(k, 3)]
            y = bending.slot[t, 4 * i + wp.min(l, 3)]
            square = inverse * inverse
            ggs = wp.dot(gk, gl)
            oos = wp.dot(ok, ol)
            # coefficients of m m^t, m m'^t, m' m^t, m' m'^t
            mm = square * (x[0] * (along * y[0] - y[2] + y[4]) + y[0] * (x[4] - x[2]) - along * ggs) - tilt * ggs
            mn = square * (x[0] * (along * y[1] - y[3] + y[4]) + y[1] * (x[4] - x[2]) - along * wp.dot(gk, ol))
            nm = square * (x[1] * (along * y[0] - y[2] + y[4]) + y[0] * (x[4] - x[3]) - along * wp.dot(ok, gl))
            nn = square * (x[1] * (along * y[1] - y[3] + y[4]) + y[1] * (x[4] - x[3]) - along * oos) + tilt * oos
            h += wp.outer(own, mm * own + mn * mo + (inverse * (y[2] - y[4])) * gk)
            h += wp.outer(mo, nm * own + nn * mo + (inverse * (y[3] - y[4])) * ok)
            h += wp.outer((inverse * (x[2] - x[4])) * gl, own)
            h += wp.outer((inverse * (x[3] - x[4])) * ol, mo)
    return h


@wp.kernel
def hessian_blocks(
    topology: Topology,
    geometry: Geometry,
    response: Response,
    bending: Bending,
    start: wp.array(dtype=wp.int32),
    contribution: wp.array(dtype=wp.vec3i),
    target: wp.array(dtype=wp.vec3i),
    diagonal: wp.array(dtype=wp.int32),
    clamp: int,
    worlds: wp.array(dtype=wp.int32),
    each: int,
    first: int,
    values: wp.array(dtype=wp.float64),
):
    """Gather each 3x3 block of the upper triangle straight into the values of the sparse matrix.

    `contribution` lists (triangle, k, l) of each block; `target` the place of each row's first value.
    """
    block = place_of(first + wp.tid(), worlds, each)
    h = mat33()
    for i in range(start[block], start[block + 1]):
        c = contribution[i]
        t = c[0]
        k = c[1]
        l = c[2]
        h += wp.transpose(response.strain[t, k]) * (response.stiffness[t] * response.strain[t, l])
        stress = response.stress[t]
        diagonal_term = membrane_geometric(topology, stress, t, k, l, clamp)
        for r in range(3):
            h[r, r] = h[r, r] + diagonal_term
        if clamp == 0:
            h += bending_geometric(topology, geometry, bending, t, k, l)
    place = target[block]
    for r in range(3):
        for c in range(3):
            if diagonal[block] == 0:
                values[place[r] + c] = h[r, c]
            elif c >= r:
                values[place[r] + c - r] = h[r, c]


@wp.func
def plate_energy(z: wp.float64, stiffness: wp.float64, reach: wp.float64) -> wp.vec3d:
    """Energy per area of a unilateral foundation, its slope and its curvature, twice continuously differentiable.

    With the depth d = reach - z into the layer above the plate: nothing for d < 0, stiffness d^3 / (6 reach) inside
    the layer, and below the plate the parabola that continues it, of constant stiffness.
    """
    d = reach - z
    if d <= ZERO:
        return vec3()
    if z > ZERO:
        return stiffness * vec3(d * d * d / (SIX * reach), -HALF * d * d / reach, d / reach)
    return stiffness * vec3(HALF * z * (z - reach) + reach * reach / SIX, z - HALF * reach, ONE)


@wp.kernel
def add_loads(
    area: wp.array(dtype=wp.float64),
    weight: wp.array(dtype=wp.float64),
    plate: wp.float64,
    reach: wp.float64,
    q: wp.array(dtype=wp.vec3d),
    diagonal_place: wp.array(dtype=wp.int32),
    second_order: int,
    worlds: wp.array(dtype=wp.int32),
    each: int,
    first: int,
    energy: wp.array(dtype=wp.float64),
    gradient: wp.array(dtype=wp.vec3d),
    values: wp.array(dtype=wp.float64),
):
    """Write the load energy of each vertex, add its force and stiffness.

    Weight: A rho g H / mu z. Plate: A times `plate_energy`, without friction or adhesion.
    """
    v = place_of(first + wp.tid(), worlds, each)
    z = q[v][2]
    contact = plate_energy(z, plate, reach)
    energy[v] = area[v] * (weight[v] * z + contact[0])
    gradient[v] = gradient[v] + vec3(ZERO, ZERO, area[v] * (weight[v] + contact[1]))
    if second_order == 1:
        place = diagonal_place[v]
        values[place] = values[place] + area[v] * contact[2]
