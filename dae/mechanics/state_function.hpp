// What a load or a motion follows: a function of time, or an expression of time and of coordinates of the
// system and their rates.
#pragma once

#include <memory>
#include <vector>

#include "dae/mechanics/expression.hpp"
#include "dae/mechanics/smooth_function.hpp"
#include "dae/mechanics/taylor.hpp"
#include "dae/mechanics/watched_function.hpp"

namespace mfs::dae {

class StateFunction final : public WatchedFunction {
 public:
  /// What one of the expression's variables stands for.
  struct Argument {
    enum class Kind { number, time, coordinate, rate };
    Kind kind = Kind::number;
    double number = 0.0;  ///< the number; of a coordinate: what is added to it
    int coordinate = -1;  ///< of the system; of a rate: whose rate
  };

  /// None: false.
  StateFunction() = default;
  StateFunction(std::nullptr_t) {}                                   // NOLINT: as a Function
  StateFunction(Function of_time) : of_time_(std::move(of_time)) {}  // NOLINT: functions of time are some
  /// One argument for each variable of the expression.
  StateFunction(Expression expression, std::vector<Argument> arguments);

  explicit operator bool() const { return of_time_ || expression_; }
  /// Those that it depends on, all different.
  const std::vector<int>& coordinates() const { return coordinates_; }
  bool has_rates() const { return has_rates_; }
  /// The function of time that it was made of; null where it was made of an expression.
  const Function& of_time() const { return of_time_; }

  /// `q`, `v`: of these coordinates. Throws InvalidInput where the value is not finite.
  double at(double t, const double* q, const double* v) const;
  /// The same; overwrites `by_q` and `by_v`, one for each of these coordinates.
  double at(double t, const double* q, const double* v, double* by_q, double* by_v) const;
  /// As a series along a motion, whose time and coordinates are series; overwrites `by_q`. Without rates.
  Taylor<double> along(const Taylor<double>& t, const std::vector<Taylor<double>>& q,
                       std::vector<Taylor<double>>& by_q) const;
  /// Adds times: SmoothFunction::add_marks, Expression::add_marks.
  void add_marks(const TimeSpan& span, std::vector<double>& marks) const;

  /// These coordinates.
  Arguments arguments(const double* q, const double* v) const override;
  /// Of the expression.
  std::vector<int> changing_operations() const override;
  bool compares(int operation) const override { return expression_->compares(operation); }
  void enclose(const Interval& t, const Interval* q, const Interval* v,
               std::vector<Interval>& results) const override;

 private:
  double checked(double t, double value) const;
  /// Values of the arguments; without rates `v` is not read.
  template <class T>
  std::vector<T> variables(const T& t, const T* q, const T* v) const;

  Function of_time_;
  std::shared_ptr<const Expression> expression_;
  std::vector<Argument> arguments_;
  std::vector<int> place_;  ///< of each argument: of its coordinate among coordinates_
  std::vector<int> coordinates_;
  bool has_rates_ = false;
};

}  // namespace mfs::dae
