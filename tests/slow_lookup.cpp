// A resolver that hangs for a minute, in place of the system's: loaded into the program by LD_PRELOAD.
// Says on standard error what it is asked for.
#include <netdb.h>
#include <unistd.h>

#include <string>

extern "C" int getaddrinfo(const char* host, const char*, const addrinfo*, addrinfo**) {
  const std::string text = std::string("looking up ") + (host != nullptr ? host : "nothing") + "\n";
  if (write(STDERR_FILENO, text.data(), text.size()) > 0) sleep(60);
  return EAI_AGAIN;
}
