// mfs info --measure, and what the program predicts from it.
#include <fstream>

#include "test/program/program_fixture.hpp"

namespace {

using nlohmann::ordered_json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class ProgramRates : public Program {
 protected:
  static ProgramRun run_in(const std::string& cache, const std::vector<std::string>& arguments) {
    Streams streams;
    streams.environment = {{"XDG_CACHE_HOME", cache}};
    return run_program(arguments, streams);
  }
};

TEST_F(ProgramRates, MeasuredOncePredictEveryMatrix) {
  const std::string cache = path("cache"), rates = cache + "/mfs/rates.json";
  const std::string a = file("a.mtx", kTriangular);
  const std::vector<std::string> analyze{"analyze", a, "--backend", "serial"};
  ProgramRun run = run_in(cache, analyze);
  EXPECT_EQ(run.code, 0);
  EXPECT_THAT(run.out, HasSubstr("\nprediction      none: 'mfs info --measure' measures"));
  run = run_in(cache, {"info", "--measure", "--backend", "serial"});
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("\nbackend         serial, 1 thread\n"), HasSubstr(rates),
                             HasSubstr("flop/s")));
  run = run_in(cache, analyze);
  EXPECT_EQ(run.code, 0);
  EXPECT_THAT(run.out, AllOf(HasSubstr("\nprediction      refactor "),
                             HasSubstr(" s, solve of one right-hand side "), Not(HasSubstr("took"))));
  run = run_in(cache, {"analyze", a, "--backend", "serial", "--json", "-"});
  const auto json = ordered_json::parse(run.out);
  EXPECT_GT(json["predicted_refactor"].get<double>(), 0);
  EXPECT_GT(json["predicted_solve"].get<double>(), 0);
  // What happened beside it; of other threads nothing is known.
  run = run_in(cache, {"solve", a, "--backend", "serial", "--refactor", "2"});
  EXPECT_THAT(run.out,
              testing::ContainsRegex("\nprediction      refactor [^(]*\\(took [^(]*solve[^(]*\\(took "));
  run = run_in(cache, {"bench", "poisson2d:4", "--threads", "2", "--json", "-"});
  EXPECT_TRUE(ordered_json::parse(run.out)["predicted_refactor"].is_null());
  // Half of the file says nothing, and harms nothing.
  const std::string text = text_of(rates);
  std::ofstream(rates) << text.substr(0, text.size() / 2);
  run = run_in(cache, analyze);
  EXPECT_EQ(run.code, 0);
  EXPECT_THAT(run.out, HasSubstr("\nprediction      none: " + rates + " is damaged"));
  EXPECT_EQ(run_in(cache, {"solve", a}).code, 0);
}

TEST_F(ProgramRates, OtherNumbersHaveNoPrediction) {
  const std::string a = file("c.mtx", "%%MatrixMarket matrix coordinate complex general\n1 1 1\n1 1 1 1\n");
  EXPECT_THAT(run_in(path("cache"), {"analyze", a}).out, HasSubstr("none: rates are those of real matrices"));
}

// Known before anything is measured, and before a device that may not be there is looked for.
TEST_F(ProgramRates, AFolderThatCannotBe) {
  const ProgramRun run = run_in(file("plain", ""), {"info", "--measure", "--backend", "cuda"});
  EXPECT_EQ(run.code, 3);
  EXPECT_THAT(run.err, HasSubstr("plain/mfs/rates.json"));
  EXPECT_EQ(run_program({"info", "--threads", "1"}).code, 2);  // of what is measured only
}

}  // namespace
