#include "dae/mechanics/expression.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <mfs/error.hpp>

#include "dae/mechanics/number_text.hpp"

namespace mfs::dae {
namespace {

bool is_zero(double x) {
  return x == 0;
}
bool is_zero(const Taylor<double>& x) {
  return x.c0 == 0 && x.c1 == 0 && x.c2 == 0;
}

double to_power(double x, double y) {
  return std::pow(x, y);
}
Taylor<double> to_power(const Taylor<double>& x, const Taylor<double>& y) {
  return y.c1 == 0 && y.c2 == 0 ? pow(x, y.c0) : exp(y * log(x));
}

/// d(x^y)/dx.
double power_by_base(double x, double y) {
  return y == 0 ? 0.0 : y * std::pow(x, y - 1);
}
Taylor<double> power_by_base(const Taylor<double>& x, const Taylor<double>& y) {
  if (y.c1 != 0 || y.c2 != 0) return y * to_power(x, y - 1.0);
  return y.c0 == 0 ? Taylor<double>(0.0) : y.c0 * pow(x, y.c0 - 1);
}

/// Whether x is less than y, as a number. Of intervals: 0 to 1 where that depends on the values in them.
template <class T>
T is_less(const T& x, const T& y) {
  return T(value_of(x) < value_of(y) ? 1.0 : 0.0);
}
Interval is_less(const Interval& x, const Interval& y) {
  return {x.high < y.low ? 1.0 : 0.0, x.low < y.high ? 1.0 : 0.0};
}
template <class T>
T is_at_most(const T& x, const T& y) {
  return T(value_of(x) <= value_of(y) ? 1.0 : 0.0);
}
Interval is_at_most(const Interval& x, const Interval& y) {
  return {x.high <= y.low ? 1.0 : 0.0, x.low <= y.high ? 1.0 : 0.0};
}
template <class T>
T is_equal(const T& x, const T& y) {
  return T(value_of(x) == value_of(y) ? 1.0 : 0.0);
}
Interval is_equal(const Interval& x, const Interval& y) {
  const bool meet = x.low <= y.high && y.low <= x.high;
  return {meet && x.low == x.high && y.low == y.high ? 1.0 : 0.0, meet ? 1.0 : 0.0};
}
template <class T>
T is_true(const T& x) {
  return T(value_of(x) != 0 ? 1.0 : 0.0);
}
Interval is_true(const Interval& x) {
  return {x.contains(0.0) ? 0.0 : 1.0, x.is_zero() ? 0.0 : 1.0};
}
template <class T>
T chosen(const T& condition, const T& then, const T& otherwise) {
  return value_of(condition) != 0 ? then : otherwise;
}
Interval chosen(const Interval& condition, const Interval& then, const Interval& otherwise) {
  if (!condition.contains(0.0)) return then;
  return condition.is_zero() ? otherwise : hull(then, otherwise);
}

Interval to_power(const Interval& x, const Interval& y) {
  return pow(x, y);
}

class OfOneVariable final : public SmoothFunction {
 public:
  OfOneVariable(Expression expression, int variable, std::vector<double> values)
      : expression_(std::move(expression)), variable_(variable), values_(std::move(values)) {}
  Jet at(double x) const override {
    std::vector<Taylor<double>> variables(values_.begin(), values_.end());
    if (variable_ >= 0) variables[variable_] = {x, 1.0, 0.0};
    const Taylor<double> series = expression_.value(variables);
    return checked(x, {series.c0, series.c1, 2 * series.c2});
  }
  Jet slope(double x) const override {
    std::vector<double> gradient;
    const double value = expression_.value(variables(x), gradient);
    return checked(x, {value, variable_ < 0 ? 0.0 : gradient[variable_], 0.0});
  }
  double value(double x) const override {
    return checked(x, {expression_.value(variables(x)), 0.0, 0.0}).value;
  }
  void add_marks(const TimeSpan& span, std::vector<double>& marks) const override {
    if (variable_ >= 0) expression_.add_marks(variable_, {values_.begin(), values_.end()}, span, marks);
  }
  std::vector<int> changing_operations() const override {
    std::vector<bool> moves(values_.size(), false);
    if (variable_ >= 0) moves[variable_] = true;
    return expression_.changing_operations(moves);
  }
  bool compares(int operation) const override { return expression_.compares(operation); }
  void enclose(const Interval& x, std::vector<Interval>& results) const override {
    std::vector<Interval> variables(values_.begin(), values_.end());
    if (variable_ >= 0) variables[variable_] = x;
    expression_.results(variables, results);
  }

 private:
  std::vector<double> variables(double x) const {
    std::vector<double> variables = values_;
    if (variable_ >= 0) variables[variable_] = x;
    return variables;
  }
  Jet checked(double x, const Jet& jet) const {
    if (!std::isfinite(jet.value) || !std::isfinite(jet.first) || !std::isfinite(jet.second))
      throw InvalidInput(expression_.name(),
                         "it or a derivative is not finite at " +
                             (variable_ < 0 ? "any time" : expression_.variables()[variable_]) + " = " +
                             number_text(x));
    return jet;
  }

  Expression expression_;
  int variable_;
  std::vector<double> values_;
};

}  // namespace

template <class T>
void Expression::evaluate(const std::vector<T>& variables, std::vector<T>& result) const {
  result.resize(operations_.size());
  for (std::size_t i = 0; i < operations_.size(); ++i) evaluate_one(i, variables, result);
}

template <class T>
void Expression::evaluate_one(std::size_t i, const std::vector<T>& variables, std::vector<T>& result) const {
  const Operation& o = operations_[i];
  const auto a = [&]() -> const T& { return result[o.a]; };
  const auto b = [&]() -> const T& { return result[o.b]; };
  switch (o.op) {
    case Op::constant:
      result[i] = T(o.constant);
      break;
    case Op::variable:
      result[i] = variables[o.a];
      break;
    case Op::add:
      result[i] = a() + b();
      break;
    case Op::subtract:
      result[i] = a() - b();
      break;
    case Op::multiply:
      result[i] = a() * b();
      break;
    case Op::divide:
      result[i] = a() / b();
      break;
    case Op::power:
      result[i] = to_power(a(), b());
      break;
    case Op::less:
      result[i] = is_less(a(), b());
      break;
    case Op::less_equal:
      result[i] = is_at_most(a(), b());
      break;
    case Op::equal:
      result[i] = is_equal(a(), b());
      break;
    case Op::both:
      result[i] = is_true(a()) * is_true(b());
      break;
    case Op::either:
      result[i] = is_true(is_true(a()) + is_true(b()));
      break;
    case Op::select:
      result[i] = chosen(a(), b(), result[o.c]);
      break;
    default:
      evaluate_function(o, result, result[i]);
  }
}

template <class T>
void Expression::evaluate_function(const Operation& o, const std::vector<T>& result, T& value) const {
  using std::sin, std::cos, std::tan, std::asin, std::acos, std::atan, std::atan2, std::sinh, std::cosh,
      std::tanh, std::exp, std::log, std::sqrt;
  const T a = result[o.a];
  switch (o.op) {
    case Op::sin:
      value = sin(a);
      break;
    case Op::cos:
      value = cos(a);
      break;
    case Op::tan:
      value = tan(a);
      break;
    case Op::asin:
      value = asin(a);
      break;
    case Op::acos:
      value = acos(a);
      break;
    case Op::atan:
      value = atan(a);
      break;
    case Op::atan2:
      value = atan2(a, result[o.b]);
      break;
    case Op::sinh:
      value = sinh(a);
      break;
    case Op::cosh:
      value = cosh(a);
      break;
    case Op::tanh:
      value = tanh(a);
      break;
    case Op::exp:
      value = exp(a);
      break;
    case Op::log:
      value = log(a);
      break;
    default:
      value = sqrt(a);
  }
}

/// Adds to the derivatives of the root by what operation i uses, given that by its result. Comparisons have
/// none.
template <class T>
void Expression::spread(std::size_t i, const std::vector<T>& result, std::vector<T>& derivative) const {
  const Operation& o = operations_[i];
  const T of = derivative[i];
  const auto add = [&](int to, const T& share) { derivative[to] = derivative[to] + share; };
  switch (o.op) {
    case Op::add:
      add(o.a, of);
      add(o.b, of);
      break;
    case Op::subtract:
      add(o.a, of);
      add(o.b, -of);
      break;
    case Op::multiply:
      add(o.a, of * result[o.b]);
      add(o.b, of * result[o.a]);
      break;
    case Op::divide:
      add(o.a, of / result[o.b]);
      add(o.b, -(of * result[i] / result[o.b]));
      break;
    case Op::power:
      add(o.a, of * power_by_base(result[o.a], result[o.b]));
      // With a constant power the logarithm need not exist.
      if (operations_[o.b].op != Op::constant) {
        using std::log;
        add(o.b, of * result[i] * log(result[o.a]));
      }
      break;
    case Op::select:
      add(value_of(result[o.a]) != 0 ? o.b : o.c, of);
      break;
    default:
      if (o.op >= Op::sin) spread_function(i, result, derivative);
  }
}

template <class T>
void Expression::spread_function(std::size_t i, const std::vector<T>& result,
                                 std::vector<T>& derivative) const {
  using std::sin, std::cos, std::sinh, std::cosh, std::sqrt;
  const Operation& o = operations_[i];
  const T x = result[o.a], z = result[i], of = derivative[i];
  const auto add = [&](int to, const T& share) { derivative[to] = derivative[to] + share; };
  switch (o.op) {
    case Op::sin:
      return add(o.a, of * cos(x));
    case Op::cos:
      return add(o.a, -(of * sin(x)));
    case Op::tan:
      return add(o.a, of * (1.0 + z * z));
    case Op::asin:
      return add(o.a, of / sqrt(1.0 - x * x));
    case Op::acos:
      return add(o.a, -(of / sqrt(1.0 - x * x)));
    case Op::atan:
      return add(o.a, of / (1.0 + x * x));
    case Op::atan2: {
      const T other = result[o.b], square = x * x + other * other;
      add(o.a, of * other / square);
      return add(o.b, -(of * x / square));
    }
    case Op::sinh:
      return add(o.a, of * cosh(x));
    case Op::cosh:
      return add(o.a, of * sinh(x));
    case Op::tanh:
      return add(o.a, of * (1.0 - z * z));
    case Op::exp:
      return add(o.a, of * z);
    case Op::log:
      return add(o.a, of / x);
    default:
      return add(o.a, of / (2.0 * z));
  }
}

template <class T>
T Expression::value(const std::vector<T>& variables) const {
  std::vector<T> result;
  evaluate(variables, result);
  return result.back();
}

template <class T>
T Expression::value(const std::vector<T>& variables, std::vector<T>& gradient) const {
  std::vector<T> result, derivative(operations_.size());
  evaluate(variables, result);
  gradient.assign(variables_.size(), T(0.0));
  derivative.back() = T(1.0);
  for (std::size_t i = operations_.size(); i-- > 0;) {
    if (is_zero(derivative[i])) continue;  // what was not selected may have no derivative
    if (operations_[i].op == Op::variable)
      gradient[operations_[i].a] = gradient[operations_[i].a] + derivative[i];
    else
      spread(i, result, derivative);
  }
  return result.back();
}

template void Expression::evaluate(const std::vector<double>&, std::vector<double>&) const;
template void Expression::evaluate(const std::vector<Interval>&, std::vector<Interval>&) const;
template void Expression::evaluate_one(std::size_t, const std::vector<Interval>&,
                                       std::vector<Interval>&) const;
template double Expression::value(const std::vector<double>&) const;
template double Expression::value(const std::vector<double>&, std::vector<double>&) const;
template Taylor<double> Expression::value(const std::vector<Taylor<double>>&) const;
template Taylor<double> Expression::value(const std::vector<Taylor<double>>&,
                                          std::vector<Taylor<double>>&) const;

Function expression_function(Expression expression, int variable, std::vector<double> values) {
  return std::make_shared<OfOneVariable>(std::move(expression), variable, std::move(values));
}

}  // namespace mfs::dae
