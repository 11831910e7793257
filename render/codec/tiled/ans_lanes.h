// A stream of words on the host: kAnsLanes states that take symbols in turns (ans.h). Symbol i of a plane belongs to lane i % kAnsLanes. All lanes take their symbol,
// then those whose tokens leave bits open take these, the lower kAnsRestBits first; words are in the order in which lanes ask for them.
//
// Bytes: kAnsLanes states (4 each), words (2 each). A stream without symbols has none of both.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "render/codec/tiled/ans.h"
#include "render/codec/tiled/ans_model.h"

namespace warpscope {

inline constexpr size_t kAnsStateBytes = kAnsLanes * sizeof(uint32_t);

/// tokenOf() of numbers. Returns whether any leaves something open.
bool findTokens(std::span<const uint32_t> numbers, std::span<uint8_t> tokens);

/// A model as writers use it.
struct AnsWriterModel {
  AnsModel model;
  static constexpr uint32_t kNear = 32;

  std::array<uint32_t, kAnsSymbols> multipliers{}, parts{};  ///< of each symbol's AnsWriterShare
  /// The first of kNear symbols one after the other, 0 behind 255, that are the most frequent such ones; what is said of
  /// these once more: two vectors of 16 lanes each hold it all, and nothing comes from memory (ans_vectors.h).
  uint8_t nearest = 0;
  std::array<uint32_t, kNear> nearMultipliers{}, nearParts{};

  explicit AnsWriterModel(const AnsModel& theModel);
};

/// Takes planes from the last to the first, and each from its end. Keeps its buffer.
class AnsWriter {
 public:
  void begin();
  /// Symbols of a model that has them.
  void putBytes(const AnsWriterModel& model, std::span<const uint8_t> symbols);
  /// Numbers, which are looked at where their tokens leave something open; the model has the tokens.
  void putNumbers(const AnsWriterModel& model, std::span<const uint32_t> numbers, std::span<const uint8_t> tokens);
  /// Appends the stream: nothing if no symbol took any bits.
  void finish(ByteVector& out) const;

 private:
  uint16_t* reserve(size_t words);

  alignas(64) std::array<uint32_t, kAnsLanes> states_{};
  std::vector<uint16_t> words_;  // filled from its end
  size_t first_ = 0;             // of those that there are
};

/// A model as readers use it.
struct AnsReaderModel {
  AnsModel model;
  std::vector<uint32_t> slots;

  explicit AnsReaderModel(const AnsModel& theModel) : model(theModel), slots(theModel.slots()) {}
};

/// Reads whatever bytes are there: past the end there are zeros, and isSound() is false.
class AnsReader {
 public:
  AnsReader() = default;
  /// A stream; one without bytes has no symbols but those of constant models.
  explicit AnsReader(std::span<const std::byte> bytes);

  void takeBytes(const AnsReaderModel& model, std::span<uint8_t> symbols);
  void takeNumbers(const AnsReaderModel& model, std::span<uint32_t> numbers);
  /// The same of two streams, whose states do not wait for each other: faster than one after the other.
  static void takeBytes(const AnsReaderModel& model, AnsReader& first, std::span<uint8_t> symbols, AnsReader& second, std::span<uint8_t> secondSymbols);
  static void takeNumbers(const AnsReaderModel& model, AnsReader& first, std::span<uint32_t> numbers, AnsReader& second, std::span<uint32_t> secondNumbers);
  /// After the last plane: whether the stream was one of just these symbols.
  bool isSound() const;

 private:
  class InVectors;

  void refill(uint32_t lanes);
  template <class T>
  void takeSymbols(const AnsReaderModel& model, std::span<T> symbols);
  template <class T>
  static size_t takeSymbols(const AnsReaderModel& model, AnsReader& first, std::span<T> symbols, AnsReader& second, std::span<T> secondSymbols);
  void takeRests(std::span<uint32_t> numbers);

  alignas(64) std::array<uint32_t, kAnsLanes> states_{};
  std::span<const std::byte> words_;
  size_t next_ = 0;  // byte of words_
  bool hasStream_ = false, isBad_ = false;
};

}  // namespace warpscope
