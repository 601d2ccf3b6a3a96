// DeclarationReader: one pass over a text of declarations, by recursive descent. Split by what is read: read_types,
// read_variables, read_pous, read_tests, read_configuration; the tokens and recovery from errors are in
// declaration_reader.cpp.
//
// In: SourceText. Out: a Project grows. Errors recover at the `;` of a declaration and at the END_ of what is open.
// Does not belong here: files (read.cpp), names, types, statements.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/diagnostics.h"
#include "frontend-st/conditions.h"
#include "frontend-st/lexer.h"
#include "frontend-st/source_text.h"
#include "plcopen/project.h"

namespace plc::st {

/// Words that give a text its structure. Others, as AT and OF, are looked at where they may occur.
enum class Word : std::uint8_t {
  kNone,
  kType,
  kEndType,
  kStruct,
  kEndStruct,
  kUnion,
  kEndUnion,
  kFunction,
  kEndFunction,
  kFunctionBlock,
  kEndFunctionBlock,
  kProgram,
  kEndProgram,
  kConfiguration,
  kEndConfiguration,
  kResource,
  kEndResource,
  kTask,
  kVar,
  kVarInput,
  kVarOutput,
  kVarInOut,
  kVarTemp,
  kVarExternal,
  kVarGlobal,
  kVarAccess,
  kVarConfig,
  kVarInst,
  kVarGeneric,
  kVarStat,
  kEndVar,
  kClass,
  kEndClass,
  kInterface,
  kEndInterface,
  kNamespace,
  kEndNamespace,
  kMethod,
  kEndMethod,
  kProperty,
  kEndProperty,
  kUsing,
  kAction,
  kEndAction,
  kActions,
  kEndActions,
  kStep,
  kEndStep,
  kInitialStep,
  kTransition,
  kEndTransition,
  kTest,
  kEndTest,
};

class DeclarationReader {
 public:
  /// `chosen` knows the defines that hold in `source`, which is its text; null: those of the compile options.
  DeclarationReader(const SourceText& source, plcopen::Project& project, core::Diagnostics& diagnostics,
                    const DeclaredText* chosen = nullptr);

  /// Everything that may be in a file.
  void read_file();
  /// A POU's head and variable sections without body and END_: the interface of `pou`. Its name stays.
  void read_interface(plcopen::Pou& pou);
  /// A head and its sections without body and END_, as TwinCAT keeps them apart from the body. What is object-oriented
  /// in the head goes to `objects` ("EXTENDS Base") and is no error. False when the text begins no POU (reported).
  bool read_head(plcopen::Pou& pou, std::vector<std::string>& objects);
  /// VAR_GLOBAL sections alone.
  void read_globals(std::vector<plcopen::Variable>& out, const std::string& list);
  /// Nothing but the pragmas.
  void read_pragmas();

 private:
  /// A part of the text, blanks and comments at its ends removed.
  struct Piece {
    std::string text;
    core::SourceRef at;
  };
  /// What a section of variables belongs to.
  enum class Owner : std::uint8_t { kFile, kConfiguration, kResource, kFunction, kFunctionBlock, kProgram, kTest };

  // declaration_reader.cpp: tokens
  void advance();
  const Token& peek(std::size_t ahead);  ///< the token `ahead` places after the current one, 1 to 4
  [[nodiscard]] std::string_view text_of(const Token& token) const { return source_.slice(token.begin, token.end); }
  [[nodiscard]] Word word_of(const Token& token) const;
  /// Says so where a keyword is not spelled as in the standard.
  void note_spelling(const Token& token, Word word);
  /// Words that no declared thing can be called.
  [[nodiscard]] static bool is_reserved(Word word);
  [[nodiscard]] bool at(TokenKind kind) const { return token_.kind == kind; }
  [[nodiscard]] bool at_text(std::string_view word) const;
  [[nodiscard]] bool is_text(const Token& token, std::string_view word) const;
  bool accept(TokenKind kind);
  bool accept_text(std::string_view word);
  [[nodiscard]] core::SourceRef place(std::uint32_t offset, core::ElementKind kind = core::ElementKind::kNone) const;
  [[nodiscard]] std::string shown(const Token& token) const;

  // declaration_reader.cpp: errors, always with result false
  bool fail(core::Code code, const Token& token, std::string message, std::string help = {});
  bool fail_expected(std::string_view wanted);
  /// `what`, opened at `opener`, has no `end`.
  bool fail_unclosed(std::string_view what, const Token& opener, std::string_view end);
  bool require(TokenKind kind, std::string_view wanted);
  bool enter(const Token& token);
  void leave() { --depth_; }
  bool refuse_keyword(Word word);
  void skip_declaration();
  void recover(std::uint32_t begin);
  void skip_to(Word end);
  void skip_to_opener();
  bool end_declaration();
  /// The name of what is refused, or nothing.
  std::string refuse(Word opener, Word end, std::string_view what);
  /// Notes where a declaration of `names` is: from `begin` to the end of the last token.
  void note_extent(std::vector<std::string> names, std::uint32_t begin);
  [[nodiscard]] std::vector<std::string> names_of(const Token& first, const Token& second) const;
  void count(std::string element, plcopen::Fate fate, const core::SourceRef& at, std::string_view reason = {});
  void keep_pragmas();
  /// Adds the comments outside of bodies to the project.
  void keep_comments();
  /// Where a body ends that goes on to `end`: past its last comment.
  [[nodiscard]] std::uint32_t last_comment(std::uint32_t begin, std::uint32_t end) const;
  void note_attributes(std::string_view pou, std::string_view variable, std::uint32_t from, std::uint32_t to);
  /// The value of {attribute 'name' := 'value'} between the token before and the current one: empty for an attribute
  /// without value, nothing when it is not there.
  [[nodiscard]] std::optional<std::string> attribute_here(std::string_view name) const;

  // declaration_reader.cpp: what all declarations have
  bool name(std::string& out, std::string_view what);
  Piece expression();
  Piece dotted_path();
  plcopen::Configuration& outside();

  // read_types.cpp
  void type_block();
  bool type_declaration(bool qualified);
  bool type_spec(plcopen::TypeSpec& out);
  bool type_spec_inner(plcopen::TypeSpec& out);
  bool array_spec(plcopen::TypeSpec& out);
  bool extend(plcopen::DataType& type, const std::shared_ptr<plcopen::TypeSpec>& extended, const Token& at);
  bool struct_spec(plcopen::TypeSpec& out);
  bool named_spec(plcopen::TypeSpec& out);
  bool generic_values(std::string& type_name);
  bool string_length(plcopen::TypeSpec& out);
  bool enumeration(plcopen::TypeSpec& out);
  bool subrange(plcopen::TypeSpec& out);
  bool initial_value(plcopen::InitialValue& out);
  bool value(plcopen::InitialValue& out);
  bool array_value(plcopen::InitialValue& out);
  bool array_element(plcopen::InitialValue& list);
  bool struct_value(plcopen::InitialValue& out);

  // read_variables.cpp
  [[nodiscard]] static bool is_section(Word word);
  void section(Owner owner, std::vector<plcopen::Variable>& out);
  void name_section(plcopen::Variable& model);
  bool variables(const plcopen::Variable& model, std::vector<plcopen::Variable>& out);
  bool access_variable(std::vector<plcopen::Variable>& out);
  bool config_variable(std::vector<plcopen::Variable>& out);
  bool qualifier(plcopen::Variable& model, const Token& opener);
  [[nodiscard]] bool section_may_stand(Word word, Owner owner, const Token& opener);
  bool begins_statement();
  bool pay(std::size_t things, std::size_t copied_bytes = 0);

  // read_pous.cpp
  void pou(Word opener_word);
  bool pou_head(plcopen::Pou& pou, Word opener_word);
  void body(plcopen::Pou& pou, const Token& opener, Word opener_word);
  void refuse_code(std::uint32_t begin, std::uint32_t end);
  /// Where pragmas that choose begin and end from `begin` to `end`, where no tokens are; `none` when there are none.
  [[nodiscard]] std::uint32_t first_choice(std::uint32_t begin, std::uint32_t end, std::uint32_t none) const;
  [[nodiscard]] std::uint32_t last_choice(std::uint32_t begin, std::uint32_t end, std::uint32_t none) const;
  /// Where the line of the first comment from `begin` to `end` begins that has a line of its own; `end` without one.
  [[nodiscard]] std::uint32_t first_comment(std::uint32_t begin, std::uint32_t end) const;
  /// Gives a body the comments from `lead` to `begin`, where it has a text.
  void keep_lead(plcopen::Body& body, std::uint32_t lead, std::uint32_t begin) const;
  [[nodiscard]] std::shared_ptr<const std::vector<std::string>> defines_at(std::uint32_t offset) const;
  void action(const std::string& owner);
  void action_body(plcopen::Pou& action, const Token& opener);
  void actions();
  void give_actions();
  bool opens_another();
  plcopen::Language language();

  // read_tests.cpp
  /// True at TEST with a text after it: TEST alone is an ordinary name.
  bool opens_test();
  void test();

  // read_configuration.cpp
  void configuration();
  void resource(plcopen::Configuration& configuration);
  bool resource_part(plcopen::Resource& resource);
  bool task(plcopen::Resource& resource);
  bool task_parameters(plcopen::Task& task);
  bool program_instance(plcopen::Resource& resource);
  bool connection(plcopen::PouInstance& instance);

  const SourceText& source_;
  plcopen::Project& project_;
  core::Diagnostics& diagnostics_;
  const DeclaredText* chosen_;
  Lexer lexer_;
  bool in_body_ = false;        ///< whose parser looks at its pragmas itself
  std::vector<Token> pragmas_;  ///< passed over and not yet kept
  std::vector<Token> kept_pragmas_;
  std::vector<Token> comments_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> bodies_;  ///< from their first token to their last, ascending
  Token token_;                                                  ///< the current one
  std::array<Token, 4> ahead_;                                   ///< those after it
  std::size_t ahead_count_ = 0;
  std::uint32_t last_end_ = 0;  ///< end of the token before the current one
  std::uint32_t depth_ = 0;
  std::size_t declared_ = 0;                     ///< variables, members and values read
  std::size_t copied_bytes_ = 0;                 ///< text of declarations read several times, for `a, b : T`
  std::vector<std::string>* objects_ = nullptr;  ///< read_head: where object-oriented words of the head go
  bool exhausted_ = false;                       ///< a limit on the whole text was reported
  std::string pou_;                              ///< name of the open POU, for messages
  /// An action, and the name of the POU it belongs to, which may follow.
  struct PendingAction {
    std::string owner;
    plcopen::Pou action;
  };
  std::vector<PendingAction> actions_;
  plcopen::Configuration outside_;
  bool has_outside_ = false;
  std::size_t outside_at_ = 0;  ///< where it belongs among the configurations: in file order
};

}  // namespace plc::st
