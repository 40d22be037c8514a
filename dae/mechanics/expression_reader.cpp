// How muParser is brought to write an expression down: its operators, functions, numbers and names are ours,
// and the "numbers" that it hands from one to the next are those of operations.
#include <muParserBase.h>

#include <charconv>
#include <cstring>
#include <deque>
#include <utility>

#include <mfs/error.hpp>

#include "dae/mechanics/expression.hpp"

namespace mfs::dae {

class ExpressionReader final : public mu::ParserBase {
 public:
  explicit ExpressionReader(Expression& expression) : expression_(expression) {
    InitCharSets();
    EnableBuiltInOprt(false);
    EnableOptimizer(false);
    InitOprt();
    InitFun();
    SetVarFactory(new_variable, this);
    AddValIdent(read_number);
  }

  void read() {
    // The only thread that reads this expression; muParser's callbacks get no pointer of ours.
    active = this;
    const std::string& text = expression_.text_;
    if (text.find_first_not_of(" \t\n\r") == std::string::npos) refuse("it is empty");
    // Choices and text are muParser's own and would compute with the numbers of operations.
    if (text.find_first_of("?:\"") != std::string::npos)
      refuse("? : and quotation marks are not known here; if(condition, then, else) chooses");
    try {
      SetExpr(text);
      const int root = number(Eval());
      if (GetNumResults() != 1) refuse("it is more than one expression");
      if (root + 1 != static_cast<int>(expression_.operations_.size()))  // the result is the last one
        write(Op::add, root, constant(0.0));
    } catch (const mu::ParserError& e) {
      refuse(e.GetMsg());
    }
  }

 private:
  using Op = Expression::Op;
  using Number = mu::value_type;

  static thread_local ExpressionReader* active;

  [[noreturn]] void refuse(const std::string& what) const {
    throw InvalidInput("expression '" + expression_.text() + "'", what);
  }

  static int number(Number x) { return static_cast<int>(x); }
  static Number write(Op op, Number a, Number b = -1, Number c = -1) {
    auto& operations = active->expression_.operations_;
    operations.push_back({op, number(a), number(b), number(c), 0.0});
    return static_cast<Number>(operations.size() - 1);
  }
  static Number constant(double value) {
    const Number n = write(Op::constant, -1);
    active->expression_.operations_.back().constant = value;
    return n;
  }
  template <Op op>
  static Number one(Number x) {
    return write(op, x);
  }
  template <Op op>
  static Number two(Number x, Number y) {
    return write(op, x, y);
  }
  template <Op op>
  static Number swapped(Number x, Number y) {
    return write(op, y, x);
  }
  static Number minus(Number x) { return write(Op::subtract, constant(0.0), x); }
  static Number plus(Number x) { return x; }
  static Number differ(Number x, Number y) { return minus_one(write(Op::equal, x, y)); }
  static Number minus_one(Number x) { return write(Op::subtract, constant(1.0), x); }
  static Number choose(Number condition, Number then, Number otherwise) {
    return write(Op::select, condition, then, otherwise);
  }
  static Number least(Number x, Number y) { return choose(write(Op::less, x, y), x, y); }
  static Number most(Number x, Number y) { return choose(write(Op::less, x, y), y, x); }
  static Number absolute(Number x) { return choose(write(Op::less, x, constant(0.0)), minus(x), x); }
  static Number sign(Number x) {
    const Number zero = constant(0.0);
    const Number below = write(Op::less, x, zero), above = write(Op::less, zero, x);
    return write(Op::subtract, above, below);
  }
  static Number log10(Number x) { return write(Op::divide, write(Op::log, x), constant(std::log(10.0))); }

  static int read_number(const char* text, int* position, Number* result) {
    if (std::strchr("0123456789.", text[0]) == nullptr || text[0] == '\0') return 0;
    double value = 0.0;
    const auto [end, error] = std::from_chars(text, text + std::strlen(text), value);
    if (error != std::errc()) return 0;
    *position += static_cast<int>(end - text);
    *result = constant(value);
    return 1;
  }

  /// Called once for each name.
  static Number* new_variable(const char* name, void* reader) {
    auto& self = *static_cast<ExpressionReader*>(reader);
    if (std::strcmp(name, "pi") == 0) {
      self.places_.push_back(constant(std::acos(-1.0)));
    } else {
      self.places_.push_back(write(Op::variable, static_cast<Number>(self.expression_.variables_.size())));
      self.expression_.variables_.emplace_back(name);
    }
    return &self.places_.back();
  }

  void InitCharSets() override {
    const char* const letters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ";
    DefineNameChars((std::string("0123456789_.") + letters).c_str());
    DefineOprtChars("+-*/^<>=!&|");
    DefineInfixOprtChars("+-");
  }
  void InitConst() override {}
  void InitOprt() override {
    DefineInfixOprt("-", minus, mu::prINFIX, false);
    DefineInfixOprt("+", plus, mu::prINFIX, false);
    DefineOprt("||", two<Op::either>, mu::prLOR);
    DefineOprt("&&", two<Op::both>, mu::prLAND);
    DefineOprt("<", two<Op::less>, mu::prCMP);
    DefineOprt(">", swapped<Op::less>, mu::prCMP);
    DefineOprt("<=", two<Op::less_equal>, mu::prCMP);
    DefineOprt(">=", swapped<Op::less_equal>, mu::prCMP);
    DefineOprt("==", two<Op::equal>, mu::prCMP);
    DefineOprt("!=", differ, mu::prCMP);
    DefineOprt("+", two<Op::add>, mu::prADD_SUB);
    DefineOprt("-", two<Op::subtract>, mu::prADD_SUB);
    DefineOprt("*", two<Op::multiply>, mu::prMUL_DIV);
    DefineOprt("/", two<Op::divide>, mu::prMUL_DIV);
    DefineOprt("^", two<Op::power>, mu::prPOW, mu::oaRIGHT);
  }
  void InitFun() override {
    DefineFun("sin", one<Op::sin>, false);
    DefineFun("cos", one<Op::cos>, false);
    DefineFun("tan", one<Op::tan>, false);
    DefineFun("asin", one<Op::asin>, false);
    DefineFun("acos", one<Op::acos>, false);
    DefineFun("atan", one<Op::atan>, false);
    DefineFun("atan2", two<Op::atan2>, false);
    DefineFun("sinh", one<Op::sinh>, false);
    DefineFun("cosh", one<Op::cosh>, false);
    DefineFun("tanh", one<Op::tanh>, false);
    DefineFun("exp", one<Op::exp>, false);
    DefineFun("log", one<Op::log>, false);
    DefineFun("log10", log10, false);
    DefineFun("sqrt", one<Op::sqrt>, false);
    DefineFun("abs", absolute, false);
    DefineFun("sign", sign, false);
    DefineFun("min", least, false);
    DefineFun("max", most, false);
    DefineFun("if", choose, false);
  }

  Expression& expression_;
  std::deque<Number> places_;  // of the variables' numbers; muParser keeps pointers
};

thread_local ExpressionReader* ExpressionReader::active = nullptr;

Expression::Expression(const std::string& text, std::string place) : text_(text), place_(std::move(place)) {
  ExpressionReader(*this).read();
}

}  // namespace mfs::dae
