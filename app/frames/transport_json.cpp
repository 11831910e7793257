// The link's text and the knobs' values.
// See transport_json.h.
#include "app/frames/transport_json.h"

#include <nlohmann/json.hpp>

#include "app/frames/transport_knobs.h"
#include "app/scene/json_document.h"
#include "app/scene/knob_json.h"

namespace warpscope {

nlohmann::json toJson(const TransportSettings& transport) {
  nlohmann::json json{{"link", net::toString(transport.link)}};
  for (const auto& row : transportKnobs()) json[std::string(row.knob->key)] = jsonOf(*row.knob, row.get(transport));
  return json;
}

void readTransport(const Node& node, TransportSettings& transport) {
  std::vector<std::string_view> keys{"link"};
  for (const auto& row : transportKnobs()) keys.push_back(row.knob->key);
  node.requireObject(keys);
  if (const auto link = node.find("link")) {
    try {
      transport.link = net::parseLinkSettings(link->string());
    } catch (const net::LinkSettingsError& error) {
      link->fail(error.what());
    }
  }
  for (const auto& row : transportKnobs())
    if (const auto given = node.find(row.knob->key)) row.set(transport, readKnob(*given, *row.knob));
}

}  // namespace warpscope
