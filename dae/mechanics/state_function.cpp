#include "dae/mechanics/state_function.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <mfs/error.hpp>

#include "dae/mechanics/number_text.hpp"

namespace mfs::dae {

using Kind = StateFunction::Argument::Kind;

StateFunction::StateFunction(Expression expression, std::vector<Argument> arguments)
    : expression_(std::make_shared<const Expression>(std::move(expression))),
      arguments_(std::move(arguments)) {
  for (const Argument& argument : arguments_) {
    const auto found = std::find(coordinates_.begin(), coordinates_.end(), argument.coordinate);
    place_.push_back(static_cast<int>(found - coordinates_.begin()));
    if (argument.kind == Kind::rate) has_rates_ = true;
    if ((argument.kind == Kind::coordinate || argument.kind == Kind::rate) && found == coordinates_.end())
      coordinates_.push_back(argument.coordinate);
  }
}

double StateFunction::checked(double t, double value) const {
  if (std::isfinite(value)) return value;
  throw InvalidInput(expression_ ? expression_->name() : "function",
                     "it or a derivative is not finite at t = " + number_text(t));
}

template <class T>
std::vector<T> StateFunction::variables(const T& t, const T* q, const T* v) const {
  std::vector<T> values;
  for (std::size_t i = 0; i < arguments_.size(); ++i) {
    const Argument& argument = arguments_[i];
    values.push_back(argument.kind == Kind::time         ? t
                     : argument.kind == Kind::coordinate ? q[place_[i]] + argument.number
                     : argument.kind == Kind::rate       ? v[place_[i]]
                                                         : T(argument.number));
  }
  return values;
}

double StateFunction::at(double t, const double* q, const double* v) const {
  return checked(t, of_time_ ? of_time_->value(t) : expression_->value(variables(t, q, v)));
}

double StateFunction::at(double t, const double* q, const double* v, double* by_q, double* by_v) const {
  if (of_time_) return at(t, q, v);
  std::fill_n(by_q, coordinates_.size(), 0.0);
  std::fill_n(by_v, coordinates_.size(), 0.0);
  std::vector<double> gradient;
  const double value = checked(t, expression_->value(variables(t, q, v), gradient));
  for (std::size_t i = 0; i < arguments_.size(); ++i) {
    if (arguments_[i].kind == Kind::coordinate) by_q[place_[i]] += checked(t, gradient[i]);
    if (arguments_[i].kind == Kind::rate) by_v[place_[i]] += checked(t, gradient[i]);
  }
  return value;
}

Taylor<double> StateFunction::along(const Taylor<double>& t, const std::vector<Taylor<double>>& q,
                                    std::vector<Taylor<double>>& by_q) const {
  by_q.assign(coordinates_.size(), Taylor<double>(0.0));
  if (of_time_) {
    const Jet f = of_time_->at(t.c0);
    return composed(t, f.value, f.first, f.second);
  }
  std::vector<Taylor<double>> gradient;
  const Taylor<double> value = expression_->value(variables<Taylor<double>>(t, q.data(), nullptr), gradient);
  for (const double c : {value.c0, value.c1, value.c2}) checked(t.c0, c);
  for (std::size_t i = 0; i < arguments_.size(); ++i) {
    if (arguments_[i].kind != Kind::coordinate) continue;
    for (const double c : {gradient[i].c0, gradient[i].c1, gradient[i].c2}) checked(t.c0, c);
    by_q[place_[i]] = by_q[place_[i]] + gradient[i];
  }
  return value;
}

void StateFunction::add_marks(const TimeSpan& span, std::vector<double>& marks) const {
  if (of_time_) of_time_->add_marks(span, marks);
  if (!expression_) return;
  int time = -1;
  std::vector<std::optional<double>> numbers;
  for (std::size_t i = 0; i < arguments_.size(); ++i) {
    numbers.emplace_back();
    if (arguments_[i].kind == Kind::time) time = static_cast<int>(i);
    if (arguments_[i].kind == Kind::number) numbers.back() = arguments_[i].number;
  }
  if (time >= 0) expression_->add_marks(time, numbers, span, marks);
}

WatchedFunction::Arguments StateFunction::arguments(const double* q, const double* v) const {
  Arguments arguments;
  for (const int i : coordinates_) {
    arguments.value.push_back(q[i]);
    arguments.rate.push_back(v[i]);
  }
  return arguments;
}

std::vector<int> StateFunction::changing_operations() const {
  if (!expression_) return {};
  std::vector<bool> moves;
  for (const Argument& argument : arguments_)
    moves.push_back(argument.kind == Kind::coordinate || argument.kind == Kind::rate);
  return expression_->changing_operations(moves);
}

void StateFunction::enclose(const Interval& t, const Interval* q, const Interval* v,
                            std::vector<Interval>& results) const {
  expression_->results(variables(t, q, v), results);
}

}  // namespace mfs::dae
