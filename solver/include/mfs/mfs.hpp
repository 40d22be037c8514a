// The one header a user includes.
#pragma once

#include <mfs/batch_solver.hpp>
#include <mfs/by_name.hpp>
#include <mfs/csr_view.hpp>
#include <mfs/error.hpp>
#include <mfs/matrix_market.hpp>
#include <mfs/options.hpp>
#include <mfs/report.hpp>
#include <mfs/solver.hpp>
#include <mfs/threads.hpp>
#include <mfs/version.hpp>
