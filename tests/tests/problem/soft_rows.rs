//! Rows that give, against another solver that has a variable for what each of them gives.

use rand::{Rng as _, SeedableRng};
use rand_chacha::ChaCha8Rng;
use wbqp::qp::{
    ActiveSet, Budget, Capacity, Clarabel, Qp, QpSolver, RowId, Solution, Status, VarId,
};

/// A problem with n variables and m rows, with what each row gives, and the same with a variable for that.
fn problems(rng: &mut ChaCha8Rng) -> (Qp, Vec<f64>, Qp) {
    let n = rng.random_range(2..=12_usize);
    let m = rng.random_range(2..=2 * n);
    let capacity = |vars| Capacity { vars, rows: m };
    let mut soft = Qp::new(capacity(n));
    let mut wide = Qp::new(capacity(n + m));
    soft.reset((0..n as u32).map(VarId::new)).expect("fits");
    wide.reset((0..(n + m) as u32).map(VarId::new))
        .expect("fits");
    let root: Vec<f64> = (0..n * n).map(|_| rng.random_range(-1.0..1.0)).collect();
    for i in 0..n {
        for j in 0..n {
            let product: f64 = (0..n).map(|k| root[i * n + k] * root[j * n + k]).sum();
            let entry = product + if i == j { 0.1 } else { 0.0 };
            soft.h_mut()[i * n + j] = entry;
            wide.h_mut()[i * (n + m) + j] = entry;
        }
        let g = rng.random_range(-1.0..1.0);
        (soft.g_mut()[i], wide.g_mut()[i]) = (g, g);
    }
    let mut compliance = Vec::new();
    let mut rows: Vec<Vec<f64>> = Vec::new();
    for i in 0..m {
        // One in four is another one over again, in other units and with limits of its own.
        let row: Vec<f64> = match rows.get(rng.random_range(0..=3 * i.max(1))) {
            Some(row) => row.iter().map(|a| 10.0 * a).collect(),
            None => (0..n).map(|_| rng.random_range(-1.0..1.0)).collect(),
        };
        let lower = rng.random_range(-3.0..3.0);
        let upper = match rng.random_range(0..4) {
            0 => lower,
            1 => f64::INFINITY,
            _ => lower + rng.random_range(0.0..2.0),
        };
        compliance.push(10_f64.powf(rng.random_range(-4.0..0.0)));
        let id = RowId::new(i as u32);
        for qp in [&mut soft, &mut wide] {
            let to = qp.push_row(id, lower, upper).expect("fits");
            to[..n].copy_from_slice(&row);
        }
        wide.row_mut(i)[n + i] = 1.0;
        wide.h_mut()[(n + i) * (n + m) + n + i] = 1.0 / compliance[i];
        rows.push(row);
    }
    for j in 0..n {
        for qp in [&mut soft, &mut wide] {
            let (lower, upper) = qp.bounds_mut();
            (lower[j], upper[j]) = (-2.0, 2.0);
        }
    }
    (soft, compliance, wide)
}

#[test]
fn rows_give_as_another_solver_says() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut count = 0;
    for problem in 0..400 {
        let (soft, compliance, wide) = problems(&mut rng);
        let (n, m) = (soft.n(), soft.m());
        let mut clarabel = Clarabel::default();
        clarabel.bind(wide.capacity()).expect("is good");
        let mut expected = Solution::new(wide.capacity());
        let status = clarabel.solve(&wide, Budget::Configured, &mut expected);
        assert_eq!(status, Ok(Status::Optimal), "{problem}");
        let mut solver = ActiveSet::default();
        solver.bind(wide.capacity()).expect("is good");
        let mut found = Solution::new(wide.capacity());
        let status = solver.solve_soft(&soft, &compliance, &mut found);
        if status == Ok(Status::Stalled) {
            continue;
        }
        assert_eq!(status, Ok(Status::Optimal), "{problem}");
        count += 1;
        let gives = compliance.iter().zip(&found.y);
        for (e, (c, y)) in found.x[n..n + m].iter_mut().zip(gives) {
            *e = -c * y;
        }
        let (cost, least) = (wide.objective(&found.x), wide.objective(&expected.x));
        let size = 1.0 + least.abs();
        assert!(
            (cost - least).abs() < 1e-5 * size,
            "{problem}: {cost} {least}"
        );
        for i in 0..m {
            let value: f64 = wide.row(i).iter().zip(&found.x).map(|(a, x)| a * x).sum();
            let (lower, upper) = (wide.row_lower()[i], wide.row_upper()[i]);
            assert!(
                (lower - 1e-7..=upper + 1e-7).contains(&value),
                "{problem}: row {i}"
            );
        }
    }
    assert!(count > 390, "{count}");
}
