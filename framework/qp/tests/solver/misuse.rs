//! Whatever is put together wrongly is an error or the status `invalid`, with the place, and never a panic.

use wbqp_qp::{
    ActiveSet, Budget, Capacity, Defect, Optimality, Qp, QpError, QpSolver, RowId, Solution,
    Status, VarId, solve,
};

const INF: f64 = f64::INFINITY;
const SMALL: Capacity = Capacity { vars: 1, rows: 1 };
const LARGE: Capacity = Capacity { vars: 2, rows: 2 };

/// Two variables, `x₁ + x₂ ≥ 1`.
fn problem() -> Qp {
    let (h, g, a) = ([2.0, 0.0, 0.0, 2.0], [0.0, 0.0], [1.0, 1.0]);
    Qp::dense(&h, &g, &a, (&[1.0], &[INF]), (&[-INF; 2], &[INF; 2])).expect("has one shape")
}

fn status_of(qp: &Qp) -> (Status, Option<Defect>) {
    let mut solver = ActiveSet::default();
    solver.bind(qp.capacity()).expect("is good");
    let mut solution = Solution::new(qp.capacity());
    let status = solver
        .solve(qp, Budget::Configured, &mut solution)
        .expect("fits");
    (status, solution.defect)
}

#[test]
fn a_solver_without_workspace_says_so() {
    let (mut solver, mut solution) = (ActiveSet::default(), Solution::new(LARGE));
    let answer = solver.solve(&problem(), Budget::Configured, &mut solution);
    assert_eq!(answer, Err(QpError::NotBound));
    assert_eq!(solution.status, Status::Unsolved);
}

#[test]
fn what_does_not_fit_is_refused() {
    let qp = problem();
    let mut solver = ActiveSet::default();
    solver.bind(SMALL).expect("is good");
    let refused = |answer| matches!(answer, Err(QpError::Capacity { .. }));
    assert!(refused(solver.solve(
        &qp,
        Budget::Configured,
        &mut Solution::new(LARGE)
    )));
    solver.bind(LARGE).expect("is good");
    assert!(refused(solver.solve(
        &qp,
        Budget::Configured,
        &mut Solution::new(SMALL)
    )));
    assert_eq!(
        solver.solve(&qp, Budget::Configured, &mut Solution::new(LARGE)),
        Ok(Status::Optimal)
    );
    let mut small = Qp::new(SMALL);
    assert!(matches!(
        small.copy_from(&qp),
        Err(QpError::Capacity { .. })
    ));
    assert!(matches!(
        small.reset([0, 1].map(VarId::new)),
        Err(QpError::Capacity { .. })
    ));
    assert_eq!(small.n(), 0);
    small.reset([VarId::new(0)]).expect("fits");
    small.push(0.0, 1.0).expect("fits");
    assert!(matches!(
        small.push(0.0, 1.0),
        Err(QpError::Capacity { .. })
    ));
}

#[test]
fn a_solution_of_another_size_is_read_as_far_as_it_goes() {
    let qp = problem();
    let mut solver = ActiveSet::default();
    solver.bind(LARGE).expect("is good");
    let mut large = Solution::new(LARGE);
    let solved = solver.solve(&qp, Budget::Configured, &mut large);
    assert_eq!(solved, Ok(Status::Optimal));
    let mut small = Solution::new(SMALL);
    small.copy_from(&large);
    assert_eq!(small.x[..], large.x[..small.x.len()]);
    large.copy_from(&small);
    assert_eq!(Optimality::of(&qp, &small).worst(), f64::INFINITY);
    assert!(Optimality::of(&qp, &large).worst() < 1e-9);
    let mut padded = small.x.clone();
    padded.resize(qp.n(), 0.0);
    assert_eq!(qp.objective(&small.x), qp.objective(&padded));
}

#[test]
fn ids_ascend() {
    let mut qp = Qp::new(LARGE);
    let order = |what, id| QpError::Order { what, id };
    assert_eq!(qp.reset([3, 2].map(VarId::new)), Err(order("variable", 2)));
    qp.reset([2, 3].map(VarId::new)).expect("ascend");
    qp.push_row(RowId::new(5), 0.0, 1.0).expect("is the first");
    for id in [4, 5] {
        assert_eq!(
            qp.push_row(RowId::new(id), 0.0, 1.0).err(),
            Some(order("row", id))
        );
    }
    qp.push(0.0, 1.0).expect("is the next");
    assert_eq!(qp.rows().last(), Some(&RowId::new(6)));
}

#[test]
fn arrays_of_other_lengths_are_named() {
    let shape = |answer: Result<Solution, QpError>| match answer {
        Err(QpError::Shape {
            name,
            got,
            expected,
        }) => (name, got, expected),
        other => panic!("{other:?}"),
    };
    let (h, g, a, r, b) = ([1.0; 4], [0.0; 2], [1.0; 2], [1.0], [0.0; 2]);
    assert_eq!(
        shape(solve(&h[..3], &g, &a, (&r, &r), (&b, &b))),
        ("h", 3, 4)
    );
    assert_eq!(
        shape(solve(&h, &g, &a[..1], (&r, &r), (&b, &b))),
        ("a", 1, 2)
    );
    assert_eq!(
        shape(solve(&h, &g, &a, (&r, &[]), (&b, &b))),
        ("row_upper", 0, 1)
    );
    assert_eq!(
        shape(solve(&h, &g, &a, (&r, &r), (&[], &b))),
        ("lower", 0, 2)
    );
    assert_eq!(
        shape(solve(&h, &g, &a, (&r, &r), (&b, &r))),
        ("upper", 1, 2)
    );
}

#[test]
fn the_first_bad_number_is_named() {
    for bad in [f64::NAN, INF, -INF] {
        for (row, column) in [(0, 1), (1, 0), (1, 1)] {
            let mut qp = problem();
            qp.h_mut()[2 * row + column] = bad;
            let defect = Some(Defect::Hessian { row, column });
            assert_eq!(status_of(&qp), (Status::Invalid, defect));
        }
        let mut qp = problem();
        qp.g_mut()[1] = bad;
        assert_eq!(status_of(&qp).1, Some(Defect::Gradient { variable: 1 }));
        let mut qp = problem();
        qp.row_mut(0)[1] = bad;
        let defect = Defect::Coefficient {
            row: 0,
            variable: 1,
        };
        assert_eq!(status_of(&qp), (Status::Invalid, Some(defect)));
    }
    for (lower, upper) in [(f64::NAN, 1.0), (0.0, f64::NAN), (INF, INF), (-INF, -INF)] {
        let mut qp = problem();
        qp.bounds_mut().0[1] = lower;
        qp.bounds_mut().1[1] = upper;
        assert_eq!(status_of(&qp).1, Some(Defect::Bound { variable: 1 }));
        let mut qp = problem();
        qp.row_limits_mut().0[0] = lower;
        qp.row_limits_mut().1[0] = upper;
        assert_eq!(status_of(&qp).1, Some(Defect::RowLimit { row: 0 }));
    }
}

#[test]
fn a_cost_that_is_no_valley_is_named() {
    let with = |h: [f64; 4]| {
        let mut qp = problem();
        qp.h_mut().copy_from_slice(&h);
        status_of(&qp)
    };
    for h in [
        [1.0, 2.0, 2.0, 1.0],
        [0.0, 1.0, 1.0, 0.0],
        [-1.0, 0.0, 0.0, 1.0],
        [1e-8, 1e-3, 1e-3, 1.0],
    ] {
        let (status, defect) = with(h);
        assert_eq!(status, Status::Invalid, "{h:?}");
        assert!(
            matches!(defect, Some(Defect::Indefinite { .. })),
            "{h:?}: {defect:?}"
        );
    }
    let defect = Some(Defect::Asymmetric { row: 1, column: 0 });
    assert_eq!(with([1.0, 0.5, 0.4, 1.0]), (Status::Invalid, defect));
    // Rounding is forgiven: an eigenvalue of −1e-12, entries that differ by a digit.
    assert_eq!(
        with([1.0, 1.0 + 1e-12, 1.0 + 1e-12, 1.0]).0,
        Status::Optimal
    );
    assert_eq!(with([1.0, 0.1 + 0.2, 0.3, 1.0]).0, Status::Optimal);
}

#[test]
fn settings_that_make_no_sense_are_named() {
    let refused = |solver: &mut ActiveSet| match solver.bind(SMALL) {
        Err(QpError::Setting { key, .. }) => key,
        other => panic!("{other:?}"),
    };
    let mut solver = ActiveSet::default();
    solver.max_iterations = Some(0);
    assert_eq!(refused(&mut solver), "max_iterations");
    solver = ActiveSet::default();
    solver.tolerance = f64::NAN;
    assert_eq!(refused(&mut solver), "tolerance");
    solver = ActiveSet::default();
    solver.budget = Some(-1.0);
    assert_eq!(refused(&mut solver), "budget");
}
