"""Other solvers, each called as function(problem) -> (status, x, y, z): status one of optimal, infeasible, unbounded,
failed; x is the solution, y and z multipliers, positive on an active upper side, or None where the solver says none."""

import numpy as np

# Curvature below this part of the largest, for each variable, is rounding of H.
FLAT = 1e-15

FAILED = ("failed", None, None, None)


def daqp(p):
    """DAQP 0.11 with tolerances at its own precision."""
    import daqp as library

    finite = lambda v: np.clip(v, -1e30, 1e30)  # noqa: E731
    upper = np.concatenate([finite(p.upper), finite(p.row_upper)])
    lower = np.concatenate([finite(p.lower), finite(p.row_lower)])
    sense = np.zeros(p.n + p.m, dtype=np.int32)
    sense[lower == upper] = 5
    H = np.ascontiguousarray(p.symmetric().astype(float))
    x, _, flag, info = library.solve(H, p.g.copy(), np.ascontiguousarray(p.A), upper, lower, sense, primal_tol=1e-9)
    if flag < 1:
        return {-1: "infeasible", -3: "unbounded"}.get(flag, "failed"), None, None, None
    multipliers = np.array(info["lam"])
    return "optimal", np.array(x), multipliers[p.n :], multipliers[: p.n]


def clarabel(p, tolerance=1e-12):
    import clarabel as library
    from scipy import sparse

    identity = np.eye(p.n)
    blocks, limits, owners = [], [], []
    everything = np.vstack([p.A, identity])
    lower, upper = np.concatenate([p.row_lower, p.lower]), np.concatenate([p.row_upper, p.upper])
    equal = lower == upper
    for chosen, sign, limit in ((equal, 1.0, upper), (~equal & np.isfinite(upper), 1.0, upper),
                                (~equal & np.isfinite(lower), -1.0, lower)):
        blocks.append(sign * everything[chosen])
        limits.append(sign * limit[chosen])
        owners += [(i, sign) for i in np.flatnonzero(chosen)]
    b = np.concatenate(limits)
    cones = [library.ZeroConeT(int(equal.sum())), library.NonnegativeConeT(len(b) - int(equal.sum()))]
    settings = library.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = tolerance
    settings.max_iter = 500
    H = sparse.csc_matrix(np.triu(p.symmetric().astype(float)))
    solver = library.DefaultSolver(H, p.g, sparse.csc_matrix(np.vstack(blocks)), b, cones, settings)
    result = solver.solve()
    status = str(result.status).lower()
    if "primalinfeasible" in status:
        status = "infeasible"
    elif "dualinfeasible" in status:
        status = "unbounded"
    elif "solved" not in status and "insufficientprogress" not in status:
        return FAILED
    else:
        status = "optimal" if status == "solved" else "almost"
    multipliers = np.zeros(p.m + p.n)
    for (i, sign), value in zip(owners, result.z):
        multipliers[i] += sign * value
    return status, np.array(result.x), multipliers[: p.m], multipliers[p.m :]


def piqp(p):
    import piqp as library

    f = np.asfortranarray
    equal = p.row_lower == p.row_upper
    solver = library.DenseSolver()
    s = solver.settings
    s.eps_abs = s.eps_duality_gap_abs = 1e-11
    s.eps_rel = s.eps_duality_gap_rel = 1e-12
    s.max_iter = 1000
    H = f(p.symmetric().astype(float))
    solver.setup(H, p.g, f(p.A[equal]), p.row_lower[equal], f(p.A[~equal]), p.row_lower[~equal], p.row_upper[~equal],
                 p.lower, p.upper)
    status = str(solver.solve()).rsplit("_", 2)
    status = "_".join(status).upper()
    r = solver.result
    if "PRIMAL_INFEASIBLE" in status:
        return "infeasible", None, None, None
    if "DUAL_INFEASIBLE" in status:
        return "unbounded", None, None, None
    if not status.endswith("SOLVED"):
        return FAILED
    y = np.zeros(p.m)
    y[equal] = r.y
    y[~equal] = r.z_u - r.z_l
    return "optimal", np.array(r.x), y, np.array(r.z_bu - r.z_bl)


def highs(p):
    import highspy as library
    from scipy import sparse

    h = library.Highs()
    h.setOptionValue("output_flag", False)
    for option in ("primal_feasibility_tolerance", "dual_feasibility_tolerance"):
        h.setOptionValue(option, 1e-10)
    h.setOptionValue("qp_regularization_value", 0.0)
    h.setOptionValue("time_limit", 60.0)
    model = library.HighsModel()
    lp = model.lp_
    lp.num_col_, lp.num_row_ = p.n, p.m
    lp.col_cost_, lp.col_lower_, lp.col_upper_ = p.g, p.lower, p.upper
    lp.row_lower_, lp.row_upper_ = p.row_lower, p.row_upper
    A = sparse.csc_matrix(p.A)
    lp.a_matrix_.format_ = library.MatrixFormat.kColwise
    lp.a_matrix_.start_, lp.a_matrix_.index_, lp.a_matrix_.value_ = A.indptr, A.indices, A.data
    H = sparse.csc_matrix(np.tril(p.symmetric().astype(float)))
    if H.nnz:
        q = model.hessian_
        q.dim_, q.format_ = p.n, library.HessianFormat.kTriangular
        q.start_, q.index_, q.value_ = H.indptr, H.indices, H.data
    h.passModel(model)
    h.run()
    status = h.getModelStatus()
    names = library.HighsModelStatus
    if status == names.kInfeasible:
        return "infeasible", None, None, None
    if status == names.kUnbounded:
        return "unbounded", None, None, None
    if status != names.kOptimal:
        return FAILED
    s = h.getSolution()
    return "optimal", np.array(s.col_value), -np.array(s.row_dual), -np.array(s.col_dual)


PEERS = {"daqp": daqp, "clarabel": clarabel, "piqp": piqp, "highs": highs}


def programme(cost, A, row_lower, row_upper, lower, upper):
    """A linear programme of HiGHS: (optimal value, x), or None."""
    from qp_problem import Problem

    n = len(cost)
    status, x, _, _ = highs(Problem(n, len(A), np.zeros((n, n)), cost, A, row_lower, row_upper, lower, upper))
    return (float(cost @ x), x) if status == "optimal" else None


def unit_rows(p):
    """The rows with limits, divided by their largest coefficient; rows of nothing keep theirs."""
    scale = np.max(np.abs(p.A), axis=1, initial=0)
    scale = 1 / np.where(scale > 0, scale, 1)
    return p.A * scale[:, None], p.row_lower * scale, p.row_upper * scale


def feasible(p):
    """Whether some point keeps all limits but for 1e-9 of their size: HiGHS, by the least violation there can be."""
    A, low, high = unit_rows(p)
    n, m = p.n, p.m
    # Units of variables in which no coefficient is above one; powers of two, so that nothing is rounded.
    unit = np.max(np.abs(A), axis=0, initial=0)
    unit = 2.0 ** np.round(np.log2(np.where(unit > 0, unit, 1)))
    A, own_lower, own_upper = A / unit, p.lower * unit, p.upper * unit
    size = lambda v: np.where(np.isfinite(v), np.abs(v), 0)  # noqa: E731
    # x and one slack t: every row and bound may be missed by t times its size.
    weight = np.concatenate([1 + size(low) + size(high), 1 + size(own_lower) + size(own_upper)])
    everything = np.vstack([A, np.eye(n)])
    lower, upper = np.concatenate([low, own_lower]), np.concatenate([high, own_upper])
    least = np.hstack([everything, weight[:, None]])
    most = np.hstack([everything, -weight[:, None]])
    rows = np.vstack([least, most])
    infinite = np.full(m + n, np.inf)
    found = programme(np.append(np.zeros(n), 1.0), rows, np.concatenate([lower, -infinite]),
                    np.concatenate([infinite, upper]), np.append(np.full(n, -np.inf), 0.0), np.full(n + 1, np.inf))
    return found is None or found[0] <= 1e-9


def farkas(p):
    """How far below zero multipliers of size one get the weighted limits, with A'y + z = 0 (HiGHS); None if they do
    not."""
    A, low, high = unit_rows(p)
    everything = np.vstack([A, np.eye(p.n)])
    lower, upper = np.concatenate([low, p.lower]), np.concatenate([high, p.upper])
    finite = lambda v: np.where(np.isfinite(v), v, 0.0)  # noqa: E731
    cost = np.concatenate([finite(upper), -finite(lower)])
    most = np.concatenate([np.isfinite(upper), np.isfinite(lower)]).astype(float)
    rows = np.hstack([everything.T, -everything.T])
    zero = np.zeros(p.n)
    found = programme(cost, rows, zero, zero, np.zeros(len(cost)), most)
    if found is None:
        return None
    size = float(np.abs(cost) @ found[1])
    return -found[0] / size if size > 0 and -found[0] > 1e-9 * size else None


def units(p):
    """Powers of two for the variables in which H has no row larger than another by much, nor a column of A."""
    H, A = np.abs(p.symmetric().astype(float)), np.abs(p.A)
    unit = np.ones(p.n)
    for _ in range(8):
        row = np.max(A * unit, axis=1, initial=0)
        rows = A * unit / np.where(row > 0, row, 1)[:, None]
        whole = np.max(H * unit * unit[:, None], initial=0)
        largest = np.max(H * unit * unit[:, None], axis=1, initial=0) / (whole if whole > 0 else 1)
        # Of a variable without curvature, its coefficients.
        largest = np.where(largest > 0, np.sqrt(largest), np.max(rows, axis=0, initial=0))
        unit = unit / np.sqrt(np.where(largest > 0, largest, 1))
    return 2.0 ** np.round(np.log2(unit))


def ray(p):
    """A direction without curvature along which the cost falls for ever, no component above one in the variables' own
    units (HiGHS), or None."""
    from qp_problem import Problem

    unit = units(p)
    A, low, high = unit_rows(Problem(p.n, p.m, p.H, p.g, p.A * unit, p.row_lower, p.row_upper, p.lower, p.upper))
    # Rows of length one that span those of H but for rounding: weak directions have the weight of strong ones.
    _, s, v = np.linalg.svd(p.symmetric().astype(float) * unit * unit[:, None])
    H, g = v[s > FLAT * p.n * np.max(s, initial=0)], p.g * unit
    size = np.max(np.abs(g), initial=0)
    if size == 0:
        return None
    recession = lambda v, side: np.where(np.isfinite(v), 0.0, side * np.inf)  # noqa: E731
    zero = np.zeros(len(H))
    found = programme(g / size, np.vstack([H, A]), np.concatenate([zero, recession(low, -1)]),
                      np.concatenate([zero, recession(high, 1)]), np.maximum(-1.0, recession(p.lower, -1)),
                      np.minimum(1.0, recession(p.upper, 1)))
    return found[1] * unit if found is not None and found[0] < -1e-7 else None


def ask(name, problem):
    """What a peer says; `failed` if it raises."""
    try:
        return PEERS[name](problem)
    except Exception as error:  # whatever a foreign library does, it is an answer about that library
        return f"failed: {type(error).__name__}: {error}", None, None, None
