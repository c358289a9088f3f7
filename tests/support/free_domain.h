#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <stdexcept>

/// A DDS domain that no other test and no program on this computer uses, as long as this object lives: tests
/// may run in parallel. The domain is reserved by a UDP port of its range that DDS itself never uses.
class FreeDomain {
 public:
  FreeDomain() {
    // Ports of higher domains lie where the system takes outgoing ports from.
    constexpr std::uint32_t kFirst = 1;
    constexpr std::uint32_t kCount = 100;
    for (std::uint32_t i = 0; i < kCount; ++i) {
      const std::uint32_t domain = kFirst + (static_cast<std::uint32_t>(getpid()) + i) % kCount;
      const int reservation = bind_port(domain, kReservedOffset);
      if (reservation < 0) continue;
      const int first_participant = bind_port(domain, kDiscoveryOffset);
      if (first_participant < 0) {
        close(reservation);
        continue;
      }
      close(first_participant);
      socket_ = reservation;
      domain_ = domain;
      return;
    }
    throw std::runtime_error("no DDS domain in 1..100 is free on this computer");
  }
  ~FreeDomain() { close(socket_); }
  FreeDomain(const FreeDomain&) = delete;
  FreeDomain& operator=(const FreeDomain&) = delete;

  std::uint32_t get() const { return domain_; }

 private:
  // Port numbers of a domain: base 7400 + 250 per domain; 10 + 2 * n is participant n's discovery port.
  static constexpr std::uint32_t kReservedOffset = 5;
  static constexpr std::uint32_t kDiscoveryOffset = 10;

  static int bind_port(std::uint32_t domain, std::uint32_t offset) {
    const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_ANY);
    address.sin_port = htons(static_cast<std::uint16_t>(7400 + 250 * domain + offset));
    // The socket interface takes every kind of address through this type.
    if (bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return fd;
    close(fd);
    return -1;
  }

  int socket_ = -1;
  std::uint32_t domain_ = 0;
};
