// Formulas that a model file gives as text: "k * hinge.angle^3 - c * hinge.angle_rate". muParser reads them,
// once: its operators and functions, replaced by ours, do not compute but write down what is to be done, as a
// list of operations each of which uses results of earlier ones,
//
//   k * a^3 - c * w       0: k   1: a   2: 3   3: 1 ^ 2   4: 0 * 3   5: c   6: w   7: 5 * 6   8: 4 - 7
//
// The list is evaluated with numbers, or with series in time (taylor.hpp), which give the derivatives by time
// of a motion. Gradients come by going through it backwards, so they are exact to rounding.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dae/mechanics/fast_changes.hpp"
#include "dae/mechanics/smooth_function.hpp"
#include "dae/mechanics/taylor.hpp"

namespace mfs::dae {

class Expression {
 public:
  /// Operators + - * / ^ < > <= >= == != && ||, functions sin cos tan asin acos atan atan2 sinh cosh tanh exp
  /// log log10 sqrt abs sign min max if, pi. Throws InvalidInput("`text`") that says what is wrong and where.
  /// `place`: where it stands, for messages about its values; may be empty.
  explicit Expression(const std::string& text, std::string place = "");

  /// As messages have it: the beginning of a long one.
  std::string text() const {
    return text_.size() <= kMostShown ? text_ : text_.substr(0, kMostShown) + "...";
  }
  /// "`place`: expression '`text`'".
  std::string name() const { return (place_.empty() ? "" : place_ + ": ") + "expression '" + text() + "'"; }
  /// Names that stand for numbers, in the order in which they are first used. They are made of letters,
  /// digits, _ and dots.
  const std::vector<std::string>& variables() const { return variables_; }

  /// T: double or Taylor<double>. `variables`: one for each name.
  template <class T>
  T value(const std::vector<T>& variables) const;
  /// The value, and in `gradient` its derivatives by all variables. Of series: the derivatives along the
  /// motion that they describe, as series.
  template <class T>
  T value(const std::vector<T>& variables, std::vector<T>& gradient) const;

  /// Adds values of the variable number `time` within `span` that no step is to pass over: where comparisons
  /// turn over, one between each two neighbours of these, and where parts of the expression change much
  /// faster than before (fast_changes.hpp). `others`: numbers that do not change; what is none changes by
  /// other things, and what depends on it is left out.
  void add_marks(int time, const std::vector<std::optional<double>>& others, const TimeSpan& span,
                 std::vector<double>& marks) const;

  /// Operations that use variables that `move`, but for sums with and multiples by what does not.
  std::vector<int> changing_operations(const std::vector<bool>& move) const;
  bool compares(int operation) const { return compares(operations_[operation].op); }
  /// Overwrites `results` by those of all operations.
  void results(const std::vector<Interval>& variables, std::vector<Interval>& results) const {
    evaluate(variables, results);
  }

 private:
  friend class ExpressionReader;
  static constexpr std::size_t kMostShown = 200;
  enum class Op {
    constant,
    variable,
    add,
    subtract,
    multiply,
    divide,
    power,
    less,
    less_equal,
    equal,
    both,
    either,
    select,  // a ? b : c
    sin,
    cos,
    tan,
    asin,
    acos,
    atan,
    atan2,
    sinh,
    cosh,
    tanh,
    exp,
    log,
    sqrt
  };
  struct Operation {
    Op op;
    int a = -1, b = -1, c = -1;  // results that it uses; of a variable: its number
    double constant = 0.0;
  };

  /// How an operation's result depends on time. `other`: on it and on nothing else; `unknown`: on other
  /// things.
  enum class Dependence { constant, linear, other, unknown };
  std::vector<Dependence> dependences(int time, const std::vector<std::optional<double>>& others) const;
  /// What is true at moments alone is not looked for.
  static bool compares(Op op) { return op == Op::less || op == Op::less_equal; }

  template <class T>
  void evaluate(const std::vector<T>& variables, std::vector<T>& result) const;
  template <class T>
  void evaluate_one(std::size_t i, const std::vector<T>& variables, std::vector<T>& result) const;
  /// Of operation i: it and what it uses, ascending.
  std::vector<std::size_t> uses(std::size_t i) const;
  template <class T>
  void evaluate_function(const Operation& operation, const std::vector<T>& result, T& value) const;
  template <class T>
  void spread(std::size_t i, const std::vector<T>& result, std::vector<T>& derivative) const;
  template <class T>
  void spread_function(std::size_t i, const std::vector<T>& result, std::vector<T>& derivative) const;

  std::string text_, place_;
  std::vector<std::string> variables_;
  std::vector<Operation> operations_;  // the last is the result
};

/// `expression` as a function of its variable number `variable`, the others having these `values`.
Function expression_function(Expression expression, int variable, std::vector<double> values);

}  // namespace mfs::dae
