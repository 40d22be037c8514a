// The program on complex matrices, and its options beyond solving: condition, determinant, precision, dump,
// and what it tells of the ladder of accuracy.
#include <cmath>
#include <complex>
#include <filesystem>
#include <string>

#include "test/program/program_fixture.hpp"

namespace {

using nlohmann::ordered_json;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;
using Complex = std::complex<double>;

const std::string kComplex = "%%MatrixMarket matrix coordinate complex general\n";
const std::string kComplexArray = "%%MatrixMarket matrix array complex general\n";
// [ 2i  1 ]
// [ 0   4 ]
const std::string kComplexTriangular = kComplex + "2 2 3\n1 1 0 2\n1 2 1 0\n2 2 4 0\n";

void expect_near(const std::vector<Complex>& x, const std::vector<Complex>& expected) {
  ASSERT_EQ(x.size(), expected.size());
  for (std::size_t i = 0; i < x.size(); ++i) EXPECT_LT(std::abs(x[i] - expected[i]), 1e-15) << i;
}

ordered_json json_of(const std::vector<std::string>& arguments) {
  const ProgramRun run = run_program(arguments);
  EXPECT_EQ(run.code, 0) << run.err;
  const auto json = ordered_json::parse(run.out);
  EXPECT_EQ(keys_of(json), kKeys);
  return json;
}

// ---- complex ----

TEST_F(Program, SolvesAComplexMatrix) {
  const std::string a = file("a.mtx", kComplexTriangular), x = path("x.mtx");
  const ProgramRun run = run_program({"solve", a, "-o", x});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("a: n = 2, 3 entries, complex\n"), HasSubstr("\nbackward error ")));
  EXPECT_THAT(text_of(x), StartsWith(kComplexArray));
  expect_near(solution<Complex>(x), {{0, -0.375}, {0.25, 0}});
  // Transposed, not conjugated.
  EXPECT_EQ(run_program({"solve", a, "--transpose", "-o", x}).code, 0);
  expect_near(solution<Complex>(x), {{0, -0.5}, {0.25, 0.125}});
}

TEST_F(Program, HermitianFiles) {
  const std::string x = path("x.mtx");
  const std::string a = file("h.mtx",
                             "%%MatrixMarket matrix coordinate complex hermitian\n"
                             "2 2 3\n1 1 2 0\n2 1 0 1\n2 2 2 0\n");
  EXPECT_EQ(run_program({"solve", a, "-o", x}).code, 0);
  expect_near(solution<Complex>(x), {Complex(2, 1) / 3.0, Complex(2, -1) / 3.0});
}

TEST_F(Program, RightHandSidesOfAComplexMatrixMayBeReal) {
  const std::string a = file("a.mtx", kComplexTriangular), x = path("x.mtx");
  EXPECT_EQ(run_program({"solve", a, "--rhs", file("r.mtx", kArray + "2 1\n2\n4\n"), "-o", x}).code, 0);
  expect_near(solution<Complex>(x), {{0, -0.5}, {1, 0}});
  const std::string b = file("b.mtx", kComplexArray + "2 2\n0 2\n0 0\n1 0\n4 0\n");
  EXPECT_EQ(run_program({"solve", a, "--rhs", b, "-o", x}).code, 0);
  expect_near(solution<Complex>(x), {{1, 0}, {0, 0}, {0, 0}, {1, 0}});
  EXPECT_THAT(complaint({"solve", file("real.mtx", kTriangular), "--rhs", b}, 3),
              HasSubstr("the right-hand sides are complex, the matrix is real"));
}

TEST_F(Program, RandomRightHandSidesOfAComplexMatrixAreComplex) {
  const std::string a = file("a.mtx", kComplex + "1 1 1\n1 1 1 0\n"), x = path("x.mtx");
  EXPECT_EQ(run_program({"solve", a, "--rhs", "random", "-o", x}).code, 0);
  const std::vector<Complex> values = solution<Complex>(x);
  EXPECT_NE(values[0].real(), 0);
  EXPECT_NE(values[0].imag(), 0);
  EXPECT_NE(values[0].real(), values[0].imag());
}

TEST_F(Program, ComplexFailuresHaveTheSameExitCodes) {
  const std::string singular = file("s.mtx", kComplex + "2 2 4\n1 1 0 1\n1 2 1 0\n2 1 0 2\n2 2 2 0\n");
  EXPECT_THAT(complaint({"solve", singular, "--rhs", "random"}, 4), StartsWith("s: numerically singular"));
  const std::string nan = file("n.mtx", kComplex + "2 2 2\n1 1 1 0\n2 2 1 nan\n");
  EXPECT_THAT(complaint({"solve", nan}, 3), HasSubstr("(row 1, column 1)"));
  const std::string third = file("t.mtx", kComplex + "1 1 1\n1 1 3 1\n"), x = path("x.mtx");
  complaint({"solve", third, "--tol", "1e-30", "-o", x}, 6);
  EXPECT_FALSE(std::filesystem::exists(x));
}

TEST_F(Program, TheFieldIsInTheReports) {
  const std::string a = file("a.mtx", kComplexTriangular);
  EXPECT_EQ(json_of({"solve", a, "--json", "-"})["field"], "complex");
  EXPECT_EQ(json_of({"solve", file("r.mtx", kTriangular), "--json", "-"})["field"], "real");
  EXPECT_THAT(run_program({"analyze", a}).out, HasSubstr("a: n = 2, 3 entries, complex\n"));
}

// Scaling and matching go by the values, in the analysis of a complex file too.
TEST_F(Program, AnalyzeUsesComplexValues) {
  std::string text = kComplex + "40 40 80\n";
  for (int i = 1; i <= 40; ++i)
    text += std::to_string(i) + " " + std::to_string(i) + " 0 0\n" + std::to_string(i) + " " +
            std::to_string(i % 40 + 1) + " 0 1\n";
  EXPECT_THAT(run_program({"analyze", file("a.mtx", text)}).out, HasSubstr("rows matched to columns"));
}

// ---- condition and determinant ----

TEST_F(Program, ConditionEstimate) {
  const std::string a = file("a.mtx", kReal + "2 2 2\n1 1 1000\n2 2 0.5\n");
  const auto json = json_of({"solve", a, "--condition", "--json", "-"});
  EXPECT_NEAR(json["condition"].get<double>(), 2000, 1e-6);
  EXPECT_TRUE(json["determinant_log_abs"].is_null());
  EXPECT_THAT(run_program({"solve", a, "--condition"}).out, HasSubstr("\ncondition       2.0e+03 "));
  EXPECT_TRUE(json_of({"solve", a, "--json", "-"})["condition"].is_null());
}

TEST_F(Program, DeterminantOfARealMatrix) {
  const std::string a = file("a.mtx", kReal + "2 2 3\n1 2 3\n2 1 2\n2 2 1\n");  // -6
  const auto json = json_of({"solve", a, "--determinant", "--json", "-"});
  EXPECT_THAT(json["determinant_phase"].get<std::vector<double>>(), ElementsAre(-1, 0));
  EXPECT_NEAR(json["determinant_log_abs"].get<double>(), std::log(6), 1e-14);
  EXPECT_THAT(run_program({"solve", a, "--determinant"}).out,
              HasSubstr("\ndeterminant     -1 exp(1.7917594692"));
}

TEST_F(Program, DeterminantOfAComplexMatrix) {
  const std::string a = file("a.mtx", kComplexTriangular);  // 8i
  const auto json = json_of({"solve", a, "--determinant", "--json", "-"});
  EXPECT_NEAR(json["determinant_phase"][0].get<double>(), 0, 1e-15);
  EXPECT_NEAR(json["determinant_phase"][1].get<double>(), 1, 1e-15);
  EXPECT_NEAR(json["determinant_log_abs"].get<double>(), std::log(8), 1e-14);
}

// They are told though the solve is refused: they say why.
TEST_F(Program, OfASingularMatrixTheDeterminantIsZero) {
  const std::string a = file("s.mtx", kReal + "2 2 4\n1 1 1\n1 2 1\n2 1 1\n2 2 1\n"), j = path("r.json");
  complaint({"solve", a, "--condition", "--determinant", "--json", j}, 4);
  const auto json = ordered_json::parse(text_of(j));
  EXPECT_TRUE(json["condition"].is_null());  // infinite
  EXPECT_THAT(json["determinant_phase"].get<std::vector<double>>(), ElementsAre(0, 0));
  EXPECT_TRUE(json["determinant_log_abs"].is_null());  // of zero
}

// 130 blocks [1 -1; -1 1] with 1e-8 more on the diagonal: singular in single precision, each of them, and
// more than are corrected.
TEST_F(Program, OtherFactorsTellWhatSinglePrecisionDoesNot) {
  std::string text = kReal + "260 260 520\n";
  for (int i = 1; i <= 260; i += 2) {
    const std::string first = std::to_string(i), second = std::to_string(i + 1);
    text += first + " " + first + " 1.00000001\n" + first + " " + second + " -1\n";
    text += second + " " + first + " -1\n" + second + " " + second + " 1.00000001\n";
  }
  const std::string a = file("a.mtx", text);
  for (const char* precision : {"single", "double"}) {
    const auto json =
        json_of({"solve", a, "--precision", precision, "--condition", "--determinant", "--json", "-"});
    EXPECT_EQ(json["determinant_phase"][0], 1) << precision;
    EXPECT_NEAR(json["determinant_log_abs"].get<double>(), 130 * std::log(2e-8), 1e-3);
    EXPECT_NEAR(json["condition"].get<double>(), 2e8, 1e4);
  }
}

// ---- precision and the ladder ----

TEST_F(Program, SinglePrecisionFactorsAreRefined) {
  const auto json = json_of({"bench", "poisson2d:20", "--precision", "single", "--json", "-"});
  EXPECT_EQ(json["precision"], "single");
  EXPECT_EQ(json["rung"], "refinement");
  EXPECT_GT(json["refinement_steps"], 0);
  EXPECT_GT(json["time_ladder"], 0);
  EXPECT_LE(json["backward_error"], 1e-12);
  const auto plain = json_of({"bench", "poisson2d:20", "--precision", "double", "--json", "-"});
  EXPECT_EQ(plain["precision"], "double");
  EXPECT_EQ(plain["rung"], "factors");
  EXPECT_EQ(plain["time_ladder"], 0);
  EXPECT_LT(json["bytes_factor"].get<double>(), 0.6 * plain["bytes_factor"].get<double>());
}

TEST_F(Program, TheTableTellsWhatTheAccuracyTook) {
  EXPECT_THAT(run_program({"bench", "poisson2d:20", "--precision", "single"}).out,
              AllOf(HasSubstr("\naccuracy by     refinement, "), HasSubstr("single precision factors\n")));
  EXPECT_THAT(run_program({"bench", "poisson2d:20"}).out, Not(HasSubstr("accuracy by")));
}

// ---- singular matrices ----

TEST_F(Program, SingularIsSolvedOnRequest) {
  const std::string a = file("s.mtx", kReal + "2 2 4\n1 1 1\n1 2 1\n2 1 1\n2 2 1\n");
  const std::string b = file("b.mtx", kArray + "2 1\n3\n3\n"), x = path("x.mtx");
  EXPECT_THAT(complaint({"solve", a, "--rhs", b, "-o", x}, 4), StartsWith("s: numerically singular"));
  EXPECT_FALSE(std::filesystem::exists(x));
  const auto json = json_of({"solve", a, "--rhs", b, "--singular", "-o", x, "--json", "-"});
  EXPECT_EQ(json["status"], "solved");
  EXPECT_EQ(json["dependent_rows"], 1);
  EXPECT_LE(json["backward_error"], 1e-12);
  const std::vector<double> found = solution(x);
  EXPECT_NEAR(found[0] + found[1], 3, 1e-12);
  EXPECT_THAT(run_program({"solve", a, "--rhs", b, "--singular"}).out,
              HasSubstr("\nsingular        to working"));
  // A row without entries has no factorization.
  const std::string empty = file("e.mtx", kReal + "2 2 2\n1 1 1\n1 2 1\n");
  EXPECT_THAT(complaint({"solve", empty, "--singular"}, 4), StartsWith("e: structurally singular"));
}

// ---- dump ----

TEST_F(Program, DumpLeavesTheFailingSystem) {
  const std::string a = file("s.mtx", kComplex + "2 2 4\n1 1 0 1\n1 2 1 0\n2 1 0 1\n2 2 1 0\n");
  const std::string b = file("b.mtx", kComplexArray + "2 1\n1 2\n3 4\n"), left = path("left");
  EXPECT_THAT(complaint({"solve", a, "--rhs", b, "--dump", left}, 4),
              HasSubstr("; the system was written to " + left + "_A.mtx and " + left + "_b.mtx"));
  expect_near(solution<Complex>(left + "_b.mtx"), {{1, 2}, {3, 4}});
  EXPECT_THAT(complaint({"solve", left + "_A.mtx", "--rhs", left + "_b.mtx"}, 4),
              HasSubstr("numerically singular"));
}

}  // namespace
