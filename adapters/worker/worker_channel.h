#pragma once

#include <cstddef>
#include <span>
#include <utility>

#include <sys/types.h>

namespace lcpbench::worker {

/// A file descriptor that is closed with its owner.
class UniqueFd {
 public:
  UniqueFd() = default;
  explicit UniqueFd(int fd) : fd_(fd) {}
  UniqueFd(UniqueFd&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  UniqueFd& operator=(UniqueFd&& other) noexcept;
  ~UniqueFd();

  int get() const { return fd_; }
  explicit operator bool() const { return fd_ >= 0; }
  void reset() { *this = UniqueFd(); }

 private:
  int fd_ = -1;
};

/// Memory that two processes share: an anonymous file, mapped. Its size is sealed, so that neither side can make the
/// other's mapping fault by shrinking it.
class SharedRegion {
 public:
  SharedRegion() = default;
  SharedRegion(SharedRegion&& other) noexcept;
  SharedRegion& operator=(SharedRegion&& other) noexcept;
  ~SharedRegion();

  /// New memory, zero, allocated at once: what cannot be had is refused here. @throws std::system_error.
  static SharedRegion create(std::size_t bytes);

  /// The region behind a descriptor that arrived from the other side. @throws std::system_error, also when it is not
  /// sealed.
  static SharedRegion adopt(UniqueFd fd);

  std::span<std::byte> bytes() const { return {data_, size_}; }
  int fd() const { return fd_.get(); }

 private:
  SharedRegion(UniqueFd fd, std::size_t bytes);

  UniqueFd fd_;
  std::byte* data_ = nullptr;
  std::size_t size_ = 0;
};

/// An anonymous file of a fixed, sealed size: what is written past its end is refused. Zero at first.
/// @throws std::system_error.
UniqueFd sealed_memory_file(const char* name, std::size_t bytes);

/// Sends one packet, with `attached` (a descriptor) when it is >= 0. Never blocks, never raises SIGPIPE.
/// @returns false, with errno, when the other side is gone or does not read.
bool send_packet(int socket, std::span<const std::byte> packet, int attached = -1);

/// Receives one packet. @param attached  takes a descriptor that came along; nullptr refuses descriptors.
/// @returns the packet's length, more than buffer.size() when it was cut; 0 when the other side is closed; -1 with
/// errno.
ssize_t receive_packet(int socket, std::span<std::byte> buffer, UniqueFd* attached, int flags = 0);

}  // namespace lcpbench::worker
