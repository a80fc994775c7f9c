//! Limits that contradict one another: which of them do, by how much, and which are given up.

use wbqp::{
    config::ControllerConfig,
    controller::{Controller, FallbackLevel, LimitRow, Measurement, Side},
    fault::Fault,
    plugin::{AnyConstraint, AnyTask, Entry, Hardness},
    prelude::*,
    qp::{ActiveSet, Budget, Capacity, Qp, QpSolver, RowId, Solution, Status, VarId},
};
use wbqp_tests::{
    adversary::Adversary,
    random_qp::{Family, random_qp},
    scenes::{KINDS, Kind, Scene},
};

/// `lower ≤ Σ effort + Σ force ≤ upper`, coefficients by position.
#[wbqp::constraint("test.linear")]
#[derive(Default)]
struct Linear {
    effort: Vec<f64>,
    /// On the force of contact 0.
    force: Vec<f64>,
    lower: f64,
    upper: f64,
    /// Change of both limits, N/s.
    rate: f64,
}

impl Constraint for Linear {
    /// The contact, if there are coefficients on its force.
    type Running = Option<ContactId>;

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(ConstraintLayout, Self::Running), BindError> {
        let layout = Layout::rows([("sum", "N")]).effort_dense();
        if self.force.is_empty() {
            return Ok((layout.limits(), None));
        }
        let contact = setup.contact("contact_0")?;
        Ok((layout.force_dense(contact).limits(), Some(contact)))
    }

    fn update(&self, contact: &mut Self::Running, tick: &Tick<'_>, rows: &mut ConstraintRows<'_>) {
        for (j, a) in self.effort.iter().enumerate() {
            rows.effort()[(0, j)] = *a;
        }
        if let Some(contact) = *contact {
            for (j, a) in self.force.iter().enumerate() {
                rows.force(contact)[(0, j)] = *a;
            }
        }
        let moved = self.rate * tick.time;
        rows.limit(0, self.lower + moved, self.upper + moved);
    }
}

/// `effort = wanted` of the first actuator, as a task.
#[wbqp::task("test.wish")]
struct Wish {
    /// N.
    wanted: f64,
}

impl Task for Wish {
    type Running = ();

    fn bind(&self, _: &mut Setup<'_>) -> Result<(Layout, ()), BindError> {
        Ok((Layout::rows([("sum", "N")]).effort_dense(), ()))
    }

    fn update(&self, (): &mut (), _: &Tick<'_>, rows: &mut Rows<'_>) {
        rows.effort()[(0, 0)] = 1.0;
        rows.b()[0] = self.wanted;
    }
}

fn add(config: &mut ControllerConfig, name: &str, linear: Linear) {
    let entry: Entry<dyn AnyConstraint> = Entry::new(name, 1.0, Hardness::Hard, Box::new(linear));
    config.constraints.push(entry);
}

fn effort(index: usize, lower: f64, upper: f64) -> Linear {
    let mut effort = vec![0.0; index + 1];
    effort[index] = 1.0;
    Linear {
        effort,
        lower,
        upper,
        ..Linear::default()
    }
}

/// The hexarotor with its tip on a wall: 1 N to 5 N, friction 0.5, rotors up to 10 N.
fn pushing() -> ControllerConfig {
    let mut config = Scene::new(Kind::Othex, 4, 0b111, 1).config();
    let contact = &mut config.contacts[0];
    (contact.friction, contact.force_min, contact.force_max) = (0.5, 2.0, 5.0);
    config
}

/// f_n ≤ `upper`, N.
fn normal_force_up_to(upper: f64) -> Linear {
    Linear {
        force: vec![0.0, 0.0, 1.0],
        lower: f64::NEG_INFINITY,
        upper,
        ..Linear::default()
    }
}

/// f_x ≥ `lower`, N.
fn tangential_force_from(lower: f64) -> Linear {
    Linear {
        force: vec![1.0, 0.0, 0.0],
        lower,
        upper: f64::INFINITY,
        ..Linear::default()
    }
}

fn ticked(config: ControllerConfig) -> Controller {
    let mut controller = Controller::new(config).expect("is valid");
    let mut measurement = Measurement::home(controller.robot(), 1);
    measurement.time = 1.0;
    controller.tick(&measurement);
    controller
}

fn explained(config: ControllerConfig) -> String {
    let controller = ticked(config);
    assert_eq!(controller.report().level, FallbackLevel::Relaxed);
    assert_eq!(controller.report().fault, Some(Fault::Infeasible));
    let explanation = controller.explain().expect("is not optimal");
    let (_, conflict) = explanation.split_once(":\n").expect("a list follows");
    let (conflict, _) = conflict.split_once("\ngiven up:").expect("and another");
    let lines = conflict.lines().map(|line| format!("{}\n", line.trim()));
    lines.collect()
}

#[test]
fn a_least_normal_force_beyond_the_largest() {
    // 2 N ≤ f_n of the contact against f_n ≤ 0.7 N.
    let mut config = pushing();
    add(&mut config, "cap", normal_force_up_to(0.7));
    assert_eq!(
        explained(config),
        "contact `contact_0`, normal force: lower limit 2.0 N, short by 1.3 N\n\
         linear of `contact_0` (`cap`), sum: upper limit 0.7 N, short by 1.3 N\n"
    );
}

#[test]
fn a_tangential_force_beyond_friction() {
    // f_x ≥ 3 N, but f_x ≤ μ/√2 f_n and f_n ≤ 5 N allow 1.7678 N: f_x is 1.2322 N short, f_n 1.2322 √2/μ = 3.4853 N.
    // The plane of the pyramid's side would have to move by 1.2322 / √(1 + μ²/2) N, the least.
    let mut config = pushing();
    add(&mut config, "pull", tangential_force_from(3.0));
    assert_eq!(
        explained(config),
        "friction pyramid of `contact_0` (`cone_0`), side 0: upper limit 0.0 N, short by 1.232 N\n\
         linear of `contact_0` (`pull`), sum: lower limit 3.0 N, short by 1.232 N\n\
         contact `contact_0`, normal force: upper limit 5.0 N, short by 3.485 N\n"
    );
}

#[test]
fn thrusts_beyond_the_rotors() {
    // u₀ + 2 u₁ ≥ 36 N with rotors up to 10 N: 6 N are missing, of the second rotor 3 N.
    let mut config = pushing();
    let lift = Linear {
        effort: vec![1.0, 2.0],
        lower: 36.0,
        upper: f64::INFINITY,
        ..Linear::default()
    };
    add(&mut config, "lift", lift);
    let controller = ticked(config);
    let report = controller.report();
    let label = |limit: &LimitRow| controller.row(limit.row).expect("exists").label.as_str();
    let mut short: Vec<(&str, f64)> = (report.conflict.iter())
        .map(|limit| (label(limit), limit.short))
        .collect();
    assert_eq!(short.len(), 3);
    short.sort_by(|a, b| a.0.cmp(b.0));
    for ((label, short), (expected, by)) in
        short
            .iter()
            .zip([("rotor_1", 6.0), ("rotor_2", 3.0), ("sum", 6.0)])
    {
        assert_eq!(*label, expected);
        assert!((short - by).abs() < 1e-9, "{label} {short}");
    }
    // The rotors cannot give: the command is at their limits.
    let command = controller.command();
    assert!((command.effort[0] - 10.0).abs() < 1e-3 && (command.effort[1] - 10.0).abs() < 1e-3);
    assert!(report.relaxed.iter().all(|limit| label(limit) == "sum"));
    let given = report.relaxed[0].short;
    assert!((given - 6.0).abs() < 1e-2, "{:?}", report.explain());
}

/// Which entries were given up, with the largest amount of each.
fn given_up(controller: &Controller) -> Vec<(String, f64)> {
    let mut all: Vec<(String, f64)> = Vec::new();
    for relaxed in &controller.report().relaxed {
        let owner = controller.row(relaxed.row).expect("exists").owner.clone();
        match all.iter_mut().find(|(name, _)| *name == owner) {
            Some((_, by)) => *by = by.max(relaxed.short),
            None => all.push((owner, relaxed.short)),
        }
    }
    all
}

#[test]
fn the_last_declared_of_those_in_conflict_goes_first() {
    let least = || effort(0, 8.0, f64::INFINITY);
    let most = || effort(0, f64::NEG_INFINITY, 3.0);
    let other = || effort(1, 1.0, 9.0);
    for (order, lost, kept) in [
        (["least", "most", "other"], "most", 8.0),
        (["most", "least", "other"], "least", 3.0),
        (["other", "most", "least"], "least", 3.0),
    ] {
        let mut config = pushing();
        for name in order {
            let linear = match name {
                "least" => least(),
                "most" => most(),
                _ => other(),
            };
            add(&mut config, name, linear);
        }
        let controller = ticked(config);
        assert_eq!(controller.report().level, FallbackLevel::Relaxed);
        let given = given_up(&controller);
        assert_eq!(given.len(), 1, "{given:?}");
        assert_eq!(given[0].0, lost);
        assert!((given[0].1 - 5.0).abs() < 5e-3, "{given:?}");
        assert!((controller.command().effort[0] - kept).abs() < 1e-9);
        assert_eq!(controller.report().resolves, 1);
    }
}

#[test]
fn hard_tasks_go_before_constraints_and_contacts_last() {
    let mut config = pushing();
    add(&mut config, "most", effort(0, f64::NEG_INFINITY, 3.0));
    let wish: Entry<dyn AnyTask> =
        Entry::new("wish", 1.0, Hardness::Hard, Box::new(Wish { wanted: 8.0 }));
    config.tasks.push(wish);
    let controller = ticked(config);
    let given = given_up(&controller);
    assert_eq!(given.len(), 1, "{given:?}");
    assert_eq!(given[0].0, "wish");
    // What is given up of a task is its residual.
    let wish = controller.report().tasks.last().expect("is the last");
    assert!(
        (wish.residual[0].abs() - given[0].1).abs() < 1e-9,
        "{wish:?} {given:?}"
    );
    assert!(given[0].1 > 1.0 && wish.cost[0] == 0.0, "{wish:?}");
    // A constraint goes before the contact's limits.
    let mut config = pushing();
    add(&mut config, "cap", normal_force_up_to(0.7));
    let controller = ticked(config);
    let given = given_up(&controller);
    assert_eq!(given.len(), 1, "{given:?}");
    assert_eq!(given[0].0, "cap");
    assert!(controller.report().contacts[0].solution[2] > 2.0 - 1e-9);
}

#[test]
fn friction_is_not_given_up() {
    let mut config = pushing();
    add(&mut config, "pull", tangential_force_from(3.0));
    let controller = ticked(config);
    let force = controller.report().contacts[0].solution;
    assert_eq!(given_up(&controller)[0].0, "pull");
    assert!(
        force[0] <= 0.5 / 2.0_f64.sqrt() * force[2] + 1e-9,
        "{force}"
    );
    assert!(force[2] <= 5.0 + 1e-9);
}

#[test]
fn as_soon_as_it_is_feasible_the_optimum_is_back() {
    let mut config = pushing();
    add(&mut config, "least", effort(0, 8.0, f64::INFINITY));
    add(&mut config, "most", effort(0, f64::NEG_INFINITY, 3.0));
    let mut without = pushing();
    add(&mut without, "least", effort(0, 8.0, f64::INFINITY));
    let (mut a, mut b) = (
        Controller::new(config).expect("valid"),
        Controller::new(without).expect("valid"),
    );
    let mut measurement = Measurement::home(a.robot(), 1);
    measurement.state.v[8] = 0.3;
    let mut tick = |a: &mut Controller, b: &mut Controller| {
        measurement.time += 0.004;
        a.tick(&measurement);
        b.tick(&measurement);
    };
    for expected in 1..=3 {
        tick(&mut a, &mut b);
        let report = a.report();
        assert_eq!(
            (report.level, report.level_ticks),
            (FallbackLevel::Relaxed, expected)
        );
        assert_eq!(report.level_since, 0.004);
        assert_eq!(report.status, Status::Infeasible);
    }
    a.deactivate("most").expect("exists");
    tick(&mut a, &mut b);
    let report = a.report();
    assert_eq!((report.level, report.fault), (FallbackLevel::Optimal, None));
    assert_eq!((report.level_ticks, report.resolves), (1, 0));
    assert!(report.relaxed.is_empty() && report.conflict.is_empty() && a.explain().is_none());
    for (a, b) in a.command().effort.iter().zip(&b.command().effort) {
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }
    // The velocity references begin anew at the measured velocity.
    let command = a.command();
    let expected = 0.3 + 0.004 * command.joint_acceleration[2];
    assert!((command.joint_velocity[2] - expected).abs() < 1e-12);
}

#[test]
fn without_a_solution_the_last_is_carried_on_and_then_the_safe_law_takes_over() {
    let mut controller = Controller::new(pushing()).expect("is valid");
    let mut measurement = Measurement::home(controller.robot(), 1);
    let mut levels = Vec::new();
    for tick in 0..20 {
        measurement.time = 0.004 * f64::from(tick);
        measurement.state.v[6] = if (3..15).contains(&tick) {
            f64::NAN
        } else {
            0.0
        };
        let report = controller.tick(&measurement).1;
        levels.push(report.level);
        if tick == 10 {
            assert_eq!(report.level_ticks, 3);
            assert!((report.level_since - 0.032).abs() < 1e-12);
            let text = controller.explain().expect("is not optimal");
            assert_eq!(text, "safe: measurement not finite: velocities");
        }
    }
    let count = |level| levels.iter().filter(|r| **r == level).count();
    assert_eq!(levels[..3], [FallbackLevel::Optimal; 3]);
    assert_eq!(levels[3..8], [FallbackLevel::Extrapolated; 5]);
    assert_eq!(levels[8..15], [FallbackLevel::Safe; 7]);
    assert_eq!(count(FallbackLevel::Optimal), 8);
}

#[test]
fn nothing_jumps_at_the_edge_of_feasibility() {
    // The upper limit comes down from 8.2 N to 7.8 N, through the lower one at 8 N.
    let mut config = pushing();
    add(&mut config, "least", effort(0, 8.0, f64::INFINITY));
    let most = Linear {
        rate: -0.1,
        ..effort(0, f64::NEG_INFINITY, 8.2)
    };
    add(&mut config, "most", most);
    let mut controller = Controller::new(config).expect("is valid");
    let mut measurement = Measurement::home(controller.robot(), 1);
    let mut last: Option<(FallbackLevel, Vec<f64>)> = None;
    let (mut changes, mut largest) = (0, 0.0_f64);
    for tick in 0..1000 {
        measurement.time = 0.004 * f64::from(tick);
        let (command, report) = controller.tick(&measurement);
        if let Some((level, effort)) = &last {
            changes += i32::from(*level != report.level);
            let jumps = effort
                .iter()
                .zip(&command.effort)
                .map(|(a, b)| (a - b).abs());
            largest = jumps.fold(largest, f64::max);
        }
        last = Some((report.level, command.effort.clone()));
    }
    println!("largest change of an effort per tick {largest:.2e} N");
    assert_eq!(changes, 1);
    assert!(largest < 1e-2, "{largest}");
}

/// Runs the same ticks several times: the level of each, and the least time that it took, µs.
fn timed(kind: Kind, ticks: u32) -> (Vec<(FallbackLevel, f64)>, u32) {
    let mut best: Vec<(FallbackLevel, f64)> = Vec::new();
    let mut most = 0;
    for round in 0..9 {
        let mut scene = Scene::new(kind, 5, u32::MAX, u32::MAX);
        scene.hard_contacts = kind != Kind::Quadruped;
        let mut config = scene.config();
        Adversary::new(1, 500).join(&mut config, "adversary");
        let mut controller = Controller::new(config).expect("is valid");
        let mut measurement = scene.measurement();
        for tick in 0..ticks {
            measurement.time = 0.004 * f64::from(tick);
            measurement.state.v[0] = (f64::from(tick) * 0.1).sin();
            let start = std::time::Instant::now();
            let report = controller.tick(&measurement).1;
            let time = 1e6 * start.elapsed().as_secs_f64();
            most = most.max(report.resolves);
            if round == 0 {
                best.push((report.level, time));
            } else {
                let best = &mut best[tick as usize];
                assert_eq!(best.0, report.level, "the same ticks");
                best.1 = best.1.min(time);
            }
        }
    }
    (best, most)
}

/// Wall-clock times: run it alone.
#[test]
#[ignore = "measures time"]
fn what_a_relaxed_tick_costs() {
    for kind in KINDS {
        let (ticks, most) = timed(kind, 4000);
        let quantiles = [FallbackLevel::Optimal, FallbackLevel::Relaxed].map(|level| {
            let of_rung = ticks.iter().filter(|t| t.0 == level);
            let mut times: Vec<f64> = of_rung.map(|t| t.1).collect();
            times.sort_by(f64::total_cmp);
            [0.5, 0.99, 1.0].map(|q| times[(q * (times.len() - 1) as f64) as usize])
        });
        let [optimal, relaxed] = quantiles;
        println!(
            "{kind:?}: optimal {optimal:.1?} µs, relaxed {relaxed:.1?} µs (p50, p99, worst); relaxed to optimal: \
             medians {:.2}, worst {:.2}, worst to the median {:.2}; up to {most} relaxed problems",
            relaxed[0] / optimal[0],
            relaxed[2] / optimal[2],
            relaxed[2] / optimal[0]
        );
    }
}

/// One limit of a conflict: coefficients and sides.
struct Member {
    a: Vec<f64>,
    lower: f64,
    upper: f64,
}

/// Whether there is a point that satisfies all of these.
fn is_feasible(n: usize, members: &[&Member]) -> bool {
    let capacity = Capacity {
        vars: n,
        rows: members.len(),
    };
    let mut qp = Qp::new(capacity);
    qp.reset((0..n as u32).map(VarId::new)).expect("ascend");
    for i in 0..n {
        qp.h_mut()[i * n + i] = 1.0;
    }
    for (i, member) in members.iter().enumerate() {
        let id = RowId::new(i as u32);
        let row = qp.push_row(id, member.lower, member.upper).expect("fits");
        row.copy_from_slice(&member.a);
    }
    let mut solver = ActiveSet::default();
    solver.bind(capacity).expect("is valid");
    let mut solution = Solution::new(capacity);
    solver
        .solve(&qp, Budget::Configured, &mut solution)
        .expect("fits");
    match solution.status {
        Status::Optimal => true,
        Status::Infeasible => false,
        other => panic!("{other:?}"),
    }
}

/// Infeasible together, feasible without any one of them.
fn is_irreducible(n: usize, members: &[Member]) -> bool {
    let all: Vec<&Member> = members.iter().collect();
    !is_feasible(n, &all)
        && (0..members.len()).all(|left_out| {
            let mut rest = all.clone();
            rest.remove(left_out);
            is_feasible(n, &rest)
        })
}

#[test]
fn the_proof_of_the_active_set_solver_is_irreducible() {
    let (mut largest, mut count) = (0, 0);
    for seed in 0..400 {
        let known = random_qp(Family::Infeasible, seed, 12);
        let qp = &known.qp;
        let (n, m) = (qp.n(), qp.m());
        let mut solver = ActiveSet::default();
        solver.bind(qp.capacity()).expect("is valid");
        let mut solution = Solution::new(qp.capacity());
        solver
            .solve(qp, Budget::Configured, &mut solution)
            .expect("fits");
        assert_eq!(solution.status, Status::Infeasible);
        let mut members = Vec::new();
        for i in 0..m + n {
            let (y, a, lower, upper) = if i < m {
                (
                    solution.y[i],
                    qp.row(i).to_vec(),
                    qp.row_lower()[i],
                    qp.row_upper()[i],
                )
            } else {
                let j = i - m;
                let mut unit = vec![0.0; n];
                unit[j] = 1.0;
                (solution.z[j], unit, qp.lower()[j], qp.upper()[j])
            };
            let size = a.iter().map(|a| a * a).sum::<f64>().sqrt();
            // A row without coefficients contradicts itself.
            if (y * size).abs() > 1e-9 || (y != 0.0 && size == 0.0) {
                let (lower, upper) = if y > 0.0 {
                    (f64::NEG_INFINITY, upper)
                } else {
                    (lower, f64::INFINITY)
                };
                members.push(Member { a, lower, upper });
            }
        }
        assert!(is_irreducible(n, &members), "seed {seed}");
        largest = largest.max(members.len());
        count += 1;
    }
    println!("{count} conflicts, of up to {largest} limits");
}

#[test]
fn the_conflict_of_a_tick_is_irreducible_and_each_shortfall_is_the_least() {
    let mut count = 0;
    for seed in 0..120 {
        let kind = KINDS[seed % KINDS.len()];
        let mut scene = Scene::new(kind, seed as u64, u32::MAX, u32::MAX);
        scene.hard_contacts = true;
        let mut config = scene.config();
        Adversary::new(seed as u64, 900).join(&mut config, "adversary");
        let mut controller = Controller::new(config).expect("is valid");
        let mut measurement = scene.measurement();
        for tick in 0..20 {
            measurement.time = 0.004 * f64::from(tick);
            controller.tick(&measurement);
            let report = controller.report();
            let qp = controller.problem();
            let n = qp.n();
            // One that contradicts itself is looked at elsewhere.
            let alone = report.conflict.len() == 2
                && report.conflict[0].multiplier == -report.conflict[1].multiplier
                && report.conflict[0].row == report.conflict[1].row;
            if report.conflict.is_empty()
                || alone
                || !report.conflict.iter().all(|c| c.limit.is_finite())
            {
                continue;
            }
            let member = |row: RowId, side: Side, limit: f64| {
                // The problem's own limit: what a substitution adds to a row is part of the one reported.
                let (asked, mut limit) = (limit, limit);
                let row_of = qp.rows().binary_search(&row);
                let a = row_of.map_or_else(
                    |_| {
                        // A bound: the variable with that limit.
                        let limits = match side {
                            Side::Lower => qp.lower(),
                            Side::Upper => qp.upper(),
                        };
                        let name = controller.row(row).expect("exists");
                        let variable = |j: &usize| {
                            let var = controller.variable(qp.vars()[*j]).expect("exists");
                            limits[*j] == asked
                                && (var.owner == name.label
                                    || var.owner == name.owner && var.label.contains("normal")
                                    || name.owner == "adversary")
                        };
                        let j = (0..n).find(variable).expect("a variable has it");
                        let mut unit = vec![0.0; n];
                        unit[j] = 1.0;
                        unit
                    },
                    |i| {
                        limit = match side {
                            Side::Lower => qp.row_lower()[i],
                            Side::Upper => qp.row_upper()[i],
                        };
                        qp.row(i).to_vec()
                    },
                );
                match side {
                    Side::Lower => Member {
                        a,
                        lower: limit,
                        upper: f64::INFINITY,
                    },
                    Side::Upper => Member {
                        a,
                        lower: f64::NEG_INFINITY,
                        upper: limit,
                    },
                }
            };
            let members: Vec<Member> = (report.conflict.iter())
                .map(|c| member(c.row, c.side, c.limit))
                .collect();
            assert!(
                is_irreducible(n, &members),
                "seed {seed}, tick {tick}: {}",
                controller.explain().expect("why")
            );
            for (k, conflict) in report.conflict.iter().enumerate() {
                // With a little less than it says the limits still contradict one another, with a little more not.
                for (share, feasible) in [(0.999, false), (1.001, true)] {
                    let mut moved: Vec<Member> = (report.conflict.iter())
                        .map(|c| member(c.row, c.side, c.limit))
                        .collect();
                    moved[k].lower -= share * conflict.short;
                    moved[k].upper += share * conflict.short;
                    let moved: Vec<&Member> = moved.iter().collect();
                    assert_eq!(is_feasible(n, &moved), feasible, "seed {seed} {conflict:?}");
                }
            }
            count += 1;
        }
    }
    println!("{count} conflicts");
    assert!(count > 100, "{count}");
}
