// The style sheet; PNG as data URLs (RFC 2397).
// See html_page.h.
#include "app/picture/html_page.h"

#include <openssl/evp.h>

#include <algorithm>

#include "app/picture/picture.h"
#include "app/picture/svg_plot.h"

namespace warpscope {
namespace {

constexpr const char* kStyle = R"(
:root{color-scheme:light dark;--ink:#1c2126;--dim:#69727b;--line:#d9dde1;--page:#fff;--mark:#f3f5f7}
@media(prefers-color-scheme:dark){:root{--ink:#e6e9ec;--dim:#98a2ab;--line:#343b42;--page:#14181b;--mark:#1e2429}}
body{font:15px/1.5 system-ui,sans-serif;color:var(--ink);background:var(--page);max-width:1240px;margin:2em auto;padding:0 1.2em}
h1{font-size:1.6em;margin:0}h2{font-size:1.15em;margin:2em 0 .4em}p{max-width:52em}
.dim,figcaption{color:var(--dim)}.headline p{font-size:1.12em;margin:.25em 0}.answer{border-left:4px solid #2b7de0;padding:.3em 1em;background:var(--mark)}.answer p{margin:.3em 0;max-width:none}
table{border-collapse:collapse;font-variant-numeric:tabular-nums}th,td{padding:.2em .7em;border-bottom:1px solid var(--line);text-align:right;white-space:nowrap}
th:first-child,td:first-child{text-align:left}th{font-weight:600;vertical-align:bottom}.wide{overflow-x:auto}
.all{margin-left:calc(min(0px,(100% - 100vw)/2 + 1.2em));width:calc(max(100%,100vw - 2.4em))}
#rows{font-size:12.5px;margin:0 auto}#rows th,#rows td{padding:.2em .4em}#rows th{white-space:normal;cursor:pointer;position:sticky;top:0;background:var(--page)}
#rows td:first-child{white-space:normal;min-width:16em}#rows td:nth-child(2){white-space:normal;overflow-wrap:anywhere;min-width:5em}
svg.plot{width:100%;height:auto;font:12px system-ui,sans-serif}svg text{fill:var(--ink)}
.grid{stroke:var(--line)}.axis{stroke:var(--dim)}.ring{fill:none;stroke:var(--ink);stroke-width:1.4}
.strip td{padding:.2em;text-align:center;vertical-align:top;font-size:.85em}.strip img{display:block;width:150px;height:auto}.case img{width:210px}.strip tbody th{text-align:left;vertical-align:top}
)";

std::string base64(const std::string& bytes) {
  std::string text(4 * ((bytes.size() + 2) / 3) + 1, '\0');
  const int length = EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()), reinterpret_cast<const unsigned char*>(bytes.data()),
                                     static_cast<int>(bytes.size()));
  text.resize(static_cast<size_t>(length));
  return text;
}

}  // namespace

std::string pageHead(const std::string& title) {
  return "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\"><title>" +
         escaped(title) + "</title><style>" + kStyle + "</style></head><body>\n";
}

std::string imageTag(const Image<Rgba8>& picture, const std::string& description, uint32_t mostPx) {
  const uint32_t width = std::min(mostPx, picture.width());
  const uint32_t height = std::max<uint32_t>(1, static_cast<uint32_t>(uint64_t{picture.height()} * width / picture.width()));
  return "<img alt=\"" + escaped(description) + "\" src=\"data:image/png;base64," + base64(encodePng(resized(picture, width, height))) + "\">";
}

}  // namespace warpscope
