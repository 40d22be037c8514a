// What differs between the versions of Trilinos, 13.2 to 16.1: all of it stands here.
#pragma once

#include <string>
#include <type_traits>

#include <Amesos2_Factory.hpp>

namespace Amesos2::Details {

template <class Query, class = void>
struct MfsIsQuery : std::false_type {};
template <class Query>
struct MfsIsQuery<Query, std::void_t<decltype(static_cast<Query>(&Amesos2::query))>> : std::true_type {};

/// How create and query take a name: by reference since the const std::string of 13.2.
using MfsName =
    std::conditional_t<MfsIsQuery<bool (*)(const std::string&)>::value, const std::string&, std::string>;

/// The symbol of query(MfsName).
inline constexpr const char* kMfsQuerySymbol =
#if _GLIBCXX_USE_CXX11_ABI
    std::is_reference_v<MfsName> ? "_ZN7Amesos25queryERKNSt7__cxx1112basic_stringIcSt11char_traitsIcESaIcEEE"
                                 : "_ZN7Amesos25queryENSt7__cxx1112basic_stringIcSt11char_traitsIcESaIcEEE";
#else
    std::is_reference_v<MfsName> ? "_ZN7Amesos25queryERKSs" : "_ZN7Amesos25queryESs";
#endif

}  // namespace Amesos2::Details
