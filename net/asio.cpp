// The parts of Boost.Asio that are no templates, compiled once.
// Boost.Asio documentation, "Using, Building, and Configuring Asio": BOOST_ASIO_SEPARATE_COMPILATION.
#include "net/asio.h"

#include <boost/asio/impl/src.hpp>
#include <boost/asio/ssl/impl/src.hpp>
