// DAQP's C workspace interface and eiquadprog's fast solver on the problems of a file; qp.sh builds it, qp.py asks it.
//
//     qp_peer FILE
//
// reads lines from standard input:
//     METHOD A B    solves the problems from A to B in order and answers with the nanoseconds of each
//     write FILE    what the last solve of every problem has found: whether it says optimal, iterations, x
//
// METHOD is one of
//     daqp_warm            one workspace; each tick is an update of all data, the active set is that of the tick before
//     daqp_warm_reduced    the same, equalities eliminated (its option eq_reduction)
//     daqp_cold            one workspace; each tick is an update of all data, only equalities are active
//     daqp_once            daqp_quadprog: everything from nothing, with its own allocations
//     eiquadprog           no warm start
//
// Problems are converted before the clock starts: DAQP gets pointers to its own arrangement of them (bounds before rows,
// of variables without any bound at the end none at all; 1e30 is no limit), eiquadprog matrices of Eigen with one-sided
// rows. The first problem of a sequence begins from nothing for all.

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cmath>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <eiquadprog/eiquadprog-fast.hpp>

extern "C" {
#include "api.h"
#include "utils.h"
}

namespace {

constexpr double kNone = 1e30;
constexpr int kEquality = DAQP_ACTIVE + DAQP_IMMUTABLE;
constexpr int kData = DAQP_UPDATE_Rinv + DAQP_UPDATE_M + DAQP_UPDATE_v + DAQP_UPDATE_d;

struct Problem {
    int n = 0, m = 0;
    bool is_first = false;
    std::vector<double> h, g, a, row_lower, row_upper, lower, upper;

    // DAQP's.
    int ms = 0;
    std::vector<double> upper_all, lower_all;
    std::vector<int> sense;

    // eiquadprog's.
    Eigen::MatrixXd H, CE, CI;
    Eigen::VectorXd g0, ce0, ci0;

    void convert() {
        for (int j = 0; j < n; ++j)
            if (std::isfinite(lower[j]) || std::isfinite(upper[j])) ms = j + 1;
        auto add = [this](double low, double high) {
            lower_all.push_back(std::isfinite(low) ? low : -kNone);
            upper_all.push_back(std::isfinite(high) ? high : kNone);
            sense.push_back(low == high ? kEquality : 0);
        };
        for (int j = 0; j < ms; ++j) add(lower[j], upper[j]);
        for (int i = 0; i < m; ++i) add(row_lower[i], row_upper[i]);

        using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
        H = Eigen::Map<const RowMajor>(h.data(), n, n);
        g0 = Eigen::Map<const Eigen::VectorXd>(g.data(), n);
        Eigen::MatrixXd rows(m + n, n);
        rows.topRows(m) = Eigen::Map<const RowMajor>(a.data(), m, n);
        rows.bottomRows(n).setIdentity();
        std::vector<std::pair<int, double>> equal, above, below;
        for (int i = 0; i < m + n; ++i) {
            const double low = i < m ? row_lower[i] : lower[i - m], high = i < m ? row_upper[i] : upper[i - m];
            if (low == high) {
                equal.emplace_back(i, low);
                continue;
            }
            if (std::isfinite(low)) above.emplace_back(i, low);
            if (std::isfinite(high)) below.emplace_back(i, high);
        }
        CE.resize(equal.size(), n);
        ce0.resize(equal.size());
        for (std::size_t k = 0; k < equal.size(); ++k) {
            CE.row(k) = rows.row(equal[k].first);
            ce0[k] = -equal[k].second;
        }
        CI.resize(above.size() + below.size(), n);
        ci0.resize(CI.rows());
        Eigen::Index k = 0;
        for (const auto &[i, limit] : above) {
            CI.row(k) = rows.row(i);
            ci0[k++] = -limit;
        }
        for (const auto &[i, limit] : below) {
            CI.row(k) = -rows.row(i);
            ci0[k++] = limit;
        }
    }

    DAQPProblem daqp(int *senses) {
        DAQPProblem p{};
        p.n = n;
        p.m = ms + m;
        p.ms = ms;
        p.H = h.data();
        p.f = g.data();
        p.A = m > 0 ? a.data() : nullptr;
        p.bupper = upper_all.data();
        p.blower = lower_all.data();
        p.sense = senses;
        return p;
    }
};

// Reads all of a problem, as whoever has just assembled it has it in the caches.
double touch(const Problem &p) {
    double sum = p.H.sum() + p.CE.sum() + p.CI.sum() + p.g0.sum() + p.ce0.sum() + p.ci0.sum();
    for (const auto *list : {&p.h, &p.g, &p.a, &p.upper_all, &p.lower_all})
        for (double value : *list) sum += value;
    for (int value : p.sense) sum += value;
    return sum;
}

std::vector<Problem> read(const char *path) {
    std::ifstream file(path, std::ios::binary);
    char magic[8];
    std::uint32_t count = 0;
    if (!file.read(magic, 8) || std::string(magic, 8) != "WBQPTK01" || !file.read(reinterpret_cast<char *>(&count), 4))
        throw std::runtime_error(std::string(path) + " is no file of problems");
    std::vector<Problem> problems(count);
    for (Problem &p : problems) {
        std::uint32_t header[4];
        file.read(reinterpret_cast<char *>(header), sizeof header);
        p.n = static_cast<int>(header[0]);
        p.m = static_cast<int>(header[1]);
        p.is_first = header[2] != 0;
        const std::size_t n = header[0], m = header[1];
        auto numbers = [&file](std::vector<double> &to, std::size_t size) {
            to.resize(size);
            file.read(reinterpret_cast<char *>(to.data()), static_cast<std::streamsize>(8 * size));
        };
        numbers(p.h, n * n);
        numbers(p.g, n);
        numbers(p.a, m * n);
        numbers(p.row_lower, m);
        numbers(p.row_upper, m);
        numbers(p.lower, n);
        numbers(p.upper, n);
        // Identities of rows and variables: nobody here has a use for them.
        file.ignore(static_cast<std::streamsize>(4 * (m + n)));
        if (!file) throw std::runtime_error(std::string(path) + " is cut off");
        p.convert();
    }
    return problems;
}

struct Outcome {
    bool is_optimal = false;
    int iterations = 0;
    std::vector<double> x;
};

using Clock = std::chrono::steady_clock;

// A workspace of DAQP, made anew where the problem's size changes.
class Daqp {
  public:
    explicit Daqp(int reduction) : reduction_(reduction) {}
    ~Daqp() { drop(); }
    Daqp(const Daqp &) = delete;
    Daqp &operator=(const Daqp &) = delete;

    long solve(Problem &p, bool is_warm, Outcome &outcome) {
        const bool fits = work_ && n_ == p.n && m_ == p.ms + p.m && ms_ == p.ms;
        if (!fits) set_up(p);
        // As its Python interface: the state of the last solve, or the problem's own.
        const bool starts = !is_warm || p.is_first || !fits;
        qp_ = p.daqp(starts ? p.sense.data() : work_->sense);
        const int mask = kData + DAQP_UPDATE_sense + (is_warm ? 0 : DAQP_UPDATE_unconstrained + DAQP_UPDATE_eliminate);
        outcome.x.resize(p.n);
        lambda_.resize(m_);
        DAQPResult result{};
        result.x = outcome.x.data();
        result.lam = lambda_.data();
        const auto start = Clock::now();
        result.exitflag = daqp_update_ldp(mask, work_, &qp_);
        if (result.exitflag >= 0) daqp_solve(&result, work_);
        const auto end = Clock::now();
        outcome.is_optimal = result.exitflag == DAQP_EXIT_OPTIMAL;
        outcome.iterations = result.iter;
        return std::chrono::duration_cast<std::chrono::nanoseconds>(end - start).count();
    }

  private:
    void set_up(Problem &p) {
        drop();
        work_ = static_cast<DAQPWorkspace *>(std::calloc(1, sizeof(DAQPWorkspace)));
        allocate_daqp_settings(work_);
        work_->settings->eq_reduction = reduction_;
        n_ = p.n;
        m_ = p.ms + p.m;
        ms_ = p.ms;
        qp_ = p.daqp(p.sense.data());
        if (setup_daqp(&qp_, work_, nullptr) < 0) throw std::runtime_error("DAQP refuses the first problem");
    }

    void drop() {
        if (!work_) return;
        free_daqp_workspace(work_);
        free_daqp_ldp(work_);
        std::free(work_);
        work_ = nullptr;
    }

    int reduction_, n_ = 0, m_ = 0, ms_ = 0;
    DAQPWorkspace *work_ = nullptr;
    DAQPProblem qp_{};
    std::vector<double> lambda_;
};

long once(Problem &p, Outcome &outcome) {
    outcome.x.resize(p.n);
    std::vector<double> lambda(p.ms + p.m);
    std::vector<int> sense = p.sense;
    DAQPProblem qp = p.daqp(sense.data());
    DAQPResult result{};
    result.x = outcome.x.data();
    result.lam = lambda.data();
    const auto start = Clock::now();
    daqp_quadprog(&result, &qp, nullptr);
    const auto end = Clock::now();
    outcome.is_optimal = result.exitflag == DAQP_EXIT_OPTIMAL;
    outcome.iterations = result.iter;
    return std::chrono::duration_cast<std::chrono::nanoseconds>(end - start).count();
}

class Eiquadprog {
  public:
    long solve(Problem &p, Outcome &outcome) {
        if (n_ != p.n || equal_ != p.CE.rows() || unequal_ != p.CI.rows()) {
            n_ = p.n;
            equal_ = p.CE.rows();
            unequal_ = p.CI.rows();
            solver_.reset(n_, equal_, unequal_);
            x_.resize(n_);
        }
        const auto start = Clock::now();
        const auto status = solver_.solve_quadprog(p.H, p.g0, p.CE, p.ce0, p.CI, p.ci0, x_);
        const auto end = Clock::now();
        outcome.is_optimal = status == eiquadprog::solvers::EIQUADPROG_FAST_OPTIMAL;
        outcome.iterations = solver_.getIteratios();
        outcome.x.assign(x_.data(), x_.data() + n_);
        return std::chrono::duration_cast<std::chrono::nanoseconds>(end - start).count();
    }

  private:
    eiquadprog::solvers::EiquadprogFast solver_;
    Eigen::VectorXd x_;
    Eigen::Index n_ = -1, equal_ = -1, unequal_ = -1;
};

void serve(std::vector<Problem> &problems) {
    std::vector<Outcome> outcomes(problems.size());
    Daqp warm(DAQP_EQ_REDUCTION_AUTO), reduced(DAQP_EQ_REDUCTION_ON), cold(DAQP_EQ_REDUCTION_AUTO);
    Eiquadprog eiquadprog;
    std::string line, method;
    volatile double sink = 0.0;
    while (std::getline(std::cin, line)) {
        std::istringstream words(line);
        words >> method;
        if (method == "write") {
            std::string path;
            words >> path;
            std::ofstream file(path);
            file << std::setprecision(17);
            for (const Outcome &outcome : outcomes) {
                file << outcome.is_optimal << ' ' << outcome.iterations;
                for (double x : outcome.x) file << ' ' << x;
                file << '\n';
            }
            file.close();
            std::cout << "done" << std::endl;
            continue;
        }
        std::size_t from = 0, to = 0;
        words >> from >> to;
        if (!words || to > problems.size()) throw std::runtime_error("METHOD A B is expected, not " + line);
        for (std::size_t k = from; k < to; ++k) {
            Problem &p = problems[k];
            Outcome &outcome = outcomes[k];
            long spent = 0;
            sink = touch(p);
            if (method == "daqp_warm") spent = warm.solve(p, true, outcome);
            else if (method == "daqp_warm_reduced") spent = reduced.solve(p, true, outcome);
            else if (method == "daqp_cold") spent = cold.solve(p, false, outcome);
            else if (method == "daqp_once") spent = once(p, outcome);
            else if (method == "eiquadprog") spent = eiquadprog.solve(p, outcome);
            else throw std::runtime_error("no method " + method);
            std::cout << spent << ' ';
        }
        std::cout << std::endl;
    }
}

}  // namespace

int main(int argc, char **argv) {
    try {
        if (argc != 2) throw std::runtime_error("qp_peer FILE");
        std::vector<Problem> problems = read(argv[1]);
        serve(problems);
    } catch (const std::exception &error) {
        std::cerr << error.what() << std::endl;
        return 1;
    }
}
