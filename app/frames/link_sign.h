// What is said of a simulated link: on a sign over the pictures, and in recordings.
#pragma once

#include <string>

#include "net/link_settings.h"

namespace warpscope {

/// What a sign says of what is simulated between a server and a client, in full and where room is scarce; empty where nothing is.
struct LinkSign {
  std::string full, brief;
  bool isOutage = false;

  bool operator==(const LinkSign&) const = default;
};
LinkSign signOf(const net::DuplexLinkSettings& link, bool hasOutage);

}  // namespace warpscope
