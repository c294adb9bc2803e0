// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/message_mutator.h"

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>

// Of libFuzzer: changes the bytes, and returns how many there are then.
extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t max_size);

namespace latticed::fuzz {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

constexpr size_t kMostStringBytes = 128;
constexpr size_t kMostAdded = 64;  // elements at once

constexpr std::array<int64_t, 24> kIntegers = {
    0,  1,  2,  3,  4,  5,  6,    7,    8,     9,     10,        12,
    16, 27, 32, 33, 63, 64, 1000, 4096, 32768, 65535, INT32_MAX, INT64_MIN};
constexpr std::array<double, 16> kDoubles = {0,
                                             -0.0,
                                             1,
                                             -1,
                                             0.5,
                                             2,
                                             1.0 / 3,
                                             1e-9,
                                             1e-300,
                                             1e6,
                                             1e15,
                                             -1e15,
                                             1e300,
                                             5e-324,
                                             std::numeric_limits<double>::infinity(),
                                             std::numeric_limits<double>::quiet_NaN()};
constexpr std::array<const char*, 13> kStrings = {
    "",        "@mesh",     "@upload",    "@watch",       "@resume",    "@topology",  "@page",
    "@points", "scene-one", "scene-two!", "second-scene", "editor-one", "gesture-one"};

template <typename Values>
auto Pick(const Values& values, Random& random) {
  return values[Below(random, values.size())];
}

int64_t Integer(Random& random) {
  const int64_t value = Pick(kIntegers, random);
  return Below(random, 4) == 0 ? ~value : value;
}

double Number(Random& random) {
  return Below(random, 2) == 0 ? Pick(kDoubles, random)
                               : std::uniform_real_distribution<double>(-2, 2)(random);
}

std::string Text(std::string text, Random& random) {
  if (Below(random, 2) == 0) return Pick(kStrings, random);
  const size_t size = text.size();
  text.resize(std::max(kMostStringBytes, size));
  text.resize(LLVMFuzzerMutate(reinterpret_cast<uint8_t*>(text.data()), size, text.size()));
  return text;
}

int EnumNumber(const FieldDescriptor* field, Random& random) {
  const auto* const type = field->enum_type();
  const auto which = static_cast<int>(Below(random, static_cast<size_t>(type->value_count()) + 1));
  return which < type->value_count() ? type->value(which)->number() : 1'000;
}

// Calls `set` with a new value of the field's type. `old` is the value of a string.
template <typename Set>
void WithValue(const FieldDescriptor* field, const std::string& old, Random& random, Set set) {
  switch (field->cpp_type()) {
    case FieldDescriptor::CPPTYPE_INT32:
      return set(static_cast<int32_t>(Integer(random)));
    case FieldDescriptor::CPPTYPE_INT64:
      return set(Integer(random));
    case FieldDescriptor::CPPTYPE_UINT32:
      return set(static_cast<uint32_t>(Integer(random)));
    case FieldDescriptor::CPPTYPE_UINT64:
      return set(static_cast<uint64_t>(Integer(random)));
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return set(Number(random));
    case FieldDescriptor::CPPTYPE_FLOAT:
      return set(static_cast<float>(Number(random)));
    case FieldDescriptor::CPPTYPE_BOOL:
      return set(Below(random, 2) == 0);
    case FieldDescriptor::CPPTYPE_STRING:
      return set(Text(old, random));
    case FieldDescriptor::CPPTYPE_ENUM:
    case FieldDescriptor::CPPTYPE_MESSAGE:
      return;
  }
}

struct SetValue {
  const Reflection& reflection;
  Message& message;
  const FieldDescriptor* field;
  void operator()(int32_t v) const { reflection.SetInt32(&message, field, v); }
  void operator()(int64_t v) const { reflection.SetInt64(&message, field, v); }
  void operator()(uint32_t v) const { reflection.SetUInt32(&message, field, v); }
  void operator()(uint64_t v) const { reflection.SetUInt64(&message, field, v); }
  void operator()(double v) const { reflection.SetDouble(&message, field, v); }
  void operator()(float v) const { reflection.SetFloat(&message, field, v); }
  void operator()(bool v) const { reflection.SetBool(&message, field, v); }
  void operator()(std::string v) const { reflection.SetString(&message, field, std::move(v)); }
};

struct AddValue {
  const Reflection& reflection;
  Message& message;
  const FieldDescriptor* field;
  void operator()(int32_t v) const { reflection.AddInt32(&message, field, v); }
  void operator()(int64_t v) const { reflection.AddInt64(&message, field, v); }
  void operator()(uint32_t v) const { reflection.AddUInt32(&message, field, v); }
  void operator()(uint64_t v) const { reflection.AddUInt64(&message, field, v); }
  void operator()(double v) const { reflection.AddDouble(&message, field, v); }
  void operator()(float v) const { reflection.AddFloat(&message, field, v); }
  void operator()(bool v) const { reflection.AddBool(&message, field, v); }
  void operator()(std::string v) const { reflection.AddString(&message, field, std::move(v)); }
};

void MutateSingle(Message& message, const FieldDescriptor* field, Random& random) {
  const Reflection& reflection = *message.GetReflection();
  const bool has = field->has_presence() && reflection.HasField(message, field);
  if (has && Below(random, 6) == 0) return reflection.ClearField(&message, field);
  if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
    Message& inner = *reflection.MutableMessage(&message, field);
    return MutateMessage(inner, random);
  }
  if (field->cpp_type() == FieldDescriptor::CPPTYPE_ENUM) {
    return reflection.SetEnumValue(&message, field, EnumNumber(field, random));
  }
  const bool is_text = field->cpp_type() == FieldDescriptor::CPPTYPE_STRING;
  WithValue(field, is_text ? reflection.GetString(message, field) : "", random,
            SetValue{reflection, message, field});
}

void MutateRepeated(Message& message, const FieldDescriptor* field, Random& random) {
  const Reflection& reflection = *message.GetReflection();
  const int size = reflection.FieldSize(message, field);
  const size_t action = Below(random, 4);
  if (size > 0 && action == 0) return reflection.RemoveLast(&message, field);
  if (size > 1 && action == 1) {
    const auto some = static_cast<int>(Below(random, static_cast<size_t>(size)));
    return reflection.SwapElements(&message, field, some, size - 1);
  }
  if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
    if (size > 0 && action == 2 && !field->is_map()) {
      const auto some = static_cast<int>(Below(random, static_cast<size_t>(size)));
      return MutateMessage(*reflection.MutableRepeatedMessage(&message, field, some), random);
    }
    return MutateMessage(*reflection.AddMessage(&message, field), random);
  }
  const size_t count = Below(random, 8) == 0 ? 1 + Below(random, kMostAdded) : 1;
  for (size_t i = 0; i < count; ++i) {
    WithValue(field, "", random, AddValue{reflection, message, field});
  }
}

}  // namespace

void MutateMessage(Message& message, Random& random) {
  const auto* const type = message.GetDescriptor();
  if (type->field_count() == 0) return;
  const FieldDescriptor* const field =
      type->field(static_cast<int>(Below(random, static_cast<size_t>(type->field_count()))));
  field->is_repeated() ? MutateRepeated(message, field, random)
                       : MutateSingle(message, field, random);
}

}  // namespace latticed::fuzz
