#pragma once

#include <concepts>
#include <cstddef>
#include <string_view>

/// Every kind of event and of journal entry that the daemon knows: one word and one message id each. An id
/// stands in systemd/cansyncd.catalog too and never changes: it is what people and programs search for.
namespace cansyncd {

struct EventKind {
  std::string_view code;  ///< stable word, the field EVENT and the member code of the topic Event
  std::string_view id;    ///< MESSAGE_ID, 32 hexadecimal digits
};

inline constexpr EventKind kEventKinds[] = {
    // the daemon itself
    {"daemon_running", "4c5c9ef5d24745db91c62e07600d267b"},
    {"daemon_stopping", "f814c668cf6d4811ad923585f9ed9e87"},
    {"daemon_stopped", "391ca7e8b1144b528e51eb4249c6dc17"},
    {"daemon_cannot_run", "8b7cb9cc1d0f4e32a50e225ba9233bb1"},
    {"configuration_wrong", "ae54e717d0094380b26d2ce54c57648f"},
    {"reload_refused", "fb609635b4eb4b0b92628f57e44b0349"},
    {"setting_changed", "d771ad9847954672a619e27b942b04ff"},
    {"setting_needs_restart", "34af9ce985354d368213e3dcdf924aac"},
    {"reload_without_change", "498178a946304a668ae4748a76be3a32"},
    {"configuration_reloaded", "1072e2fb0b624a6f9cea833680f0ce93"},
    {"configuration_last_good", "5d7e1c2b8f9a4d06a3e4b17c60f2d981"},
    {"configuration_differs", "c81f5a3e7b2d46f09d6a0e3b94f7c512"},
    {"configuration_agrees", "7a40d9e6c3b84f15b2e8d10f6a95c374"},
    {"configuration_not_kept", "e2b97f046ad14c83965bf1d07c3e8a2f"},
    {"profile_unusable", "94c6d83f1e7b4a50b8f2067d5e3ac91b"},
    {"fault_left_out", "78dfe9667fe042c5a4a63d2a1419ca14"},
    {"network_lost", "b0d5e8a172c94f63a8e41f7d936cb205"},
    {"network_joined", "3f9c6d20e81b47a5bd07c4a2f15e9863"},
    {"configuration_refused", "47a2bdf20e5040278d91104c8b40db95"},
    {"restart_pending", "3f86aa1999bc433f9926f46952c8375e"},
    {"sleep_not_inhibited", "7a07c1ecbc954000889d102d16e93821"},
    {"sleep_inhibited", "ade0763c6b754be69fa37b63a7a5d308"},
    {"realtime_granted", "3d6ea12d3de34cfcb1961bec4d65ecf1"},
    {"realtime_missing", "c3f342b485b9474d935d8fbe0f607c79"},
    {"stack_size_kept", "0a5b950f045d47278f0daf6a169664b2"},
    {"recorder_off", "805eb1596ef64c93ab43277f93f0ccab"},
    {"flight_recording", "07182ec6123046b0869a4213643cc5ea"},
    {"flight_recording_failed", "4d9f876a6c6e4a01894a61664c064b60"},
    {"trace_ended", "563af7dc8a1e44b487256e44ba5099e3"},
    {"trace_failed", "4f72754c1cd547c1bd5ba9df858a48e3"},
    {"journal_entries_lost", "dc5610fb208141c49df916a8094e20ef"},
    {"event_not_published", "1098b59a2c8b4367852f768a525810ae"},
    {"metrics_not_written", "0c247d9974d14332af5b42849b9d5e08"},
    {"metrics_written_again", "9d8f81e7805e42b6a6e126d0ee7fe541"},
    // operating state and SYNC edges
    {"state_changed", "0f1f56f390e147efa7053ec4623038f4"},
    {"syncs_missed", "b6e9e55536114dd2b6c5fb2887fef730"},
    {"syncs_kept", "ef1b58bf5a854ccd929d3ad1f8136e41"},
    // slaves
    {"slave_responds", "14393497a6c74d1c8e546f3a70f31767"},
    {"slave_lost", "3db143a82e214bd78edd8e7a2306b344"},
    {"slave_returned", "f6ac62e901de462ea1a43c88552bd43b"},
    {"slave_checked", "a33d3448a524433e86a6e9d51315e29c"},
    {"slave_check_failed", "c1fd4154540a4fb399ac9967d4153a95"},
    {"slave_identified", "0d099b5fabee49c28d5a66e064200fdf"},
    {"wrong_drive", "eb5006a838e74cc986ba2dfb14da71c7"},
    {"duplicate_slave", "112876964f7845e3bc5350d8ab7e8b52"},
    {"unknown_slave", "3a3dba65c0ce43f6858f7493712c3723"},
    {"slave_released", "078cfc5aed394f4d8019895a49f93d86"},
    {"slave_synchronized", "dafdbd529c854db697a8e25aec15fe85"},
    {"slave_not_synchronized", "c37eda9dadd04c6f8c03454b071b8e8b"},
    {"slave_status_refused", "43e6687e89f7408cab16e8ebbc104706"},
    {"all_synchronized", "e6aab9e3b1864172b8c4f00a824be533"},
    {"slave_number_twice", "1b3cee7992ae4cfcbb5a82f45911966a"},
    // reference values
    {"references_stopped", "e11edbd3b1ed494fadc485ff29d8a78a"},
    {"references_released", "4722039368214b6da5159d7ab5a070c9"},
    {"references_too_old", "3a6248b463b748da88866b04924397e0"},
    {"references_held", "7a9544b107084a348c0078276de6aa0c"},
    {"references_missing", "1837310b20d745f6bdf9263848a7e7f1"},
    {"references_back", "7ce7499a68c54c1a9ad83b9819f7cbe2"},
    {"reference_writer_began", "70c75b63f2824ba1a1ec03ace7b52203"},
    {"reference_writer_taken_over", "377dda9fea624c7a8527bdc95f32fee5"},
    {"writer_waits", "338f30f903a74f20bb2575ba41f2103e"},
    {"reference_writer_lost", "0d28bfa8fac54b1388e00014670402df"},
    {"reference_given_up", "202bd98cefbe47a4a828f17411258056"},
    {"reference_mapping_changed", "3f8c7f957eaa48fb92279c4ba43a0f7d"},
    {"reference_deadline_missed", "31ccae87e7974928a619614b5ed46d55"},
    {"reference_refused", "5410165bf8504fffad4b25ab1f3ceec2"},
    {"reference_refusals_over", "ff20721e58704ff8bd5af862bc71c2de"},
    {"failsafe_control_word", "9fe2e79502104e7a88540f6ec43bc960"},
    {"failsafe_control_word_ended", "e94d1c0118a0455c9a9ec483cee766b1"},
    // actual values that an application releases
    {"actual_writer_began", "4d55a51c2cdd4955b77de54a173a003b"},
    {"actual_writer_lost", "0ab38903e7e046aa9dbe998d58213e4e"},
    {"actual_refused", "4bd17676e82a4034837118ab6e550f93"},
    {"application_began", "37ea7fa23dfa4b8293662f3ac387c8d1"},
    {"application_lost", "28aa24c98700487895aca7dcd792d7b5"},
    {"application_refused", "05255cf3a12d42c4b50c5441460bfcc0"},
    // the process image that an application writes, and run and stop that follow one
    {"image_writer_began", "ad7a65f46571406cb9d88a62e21cd8a1"},
    {"image_writer_lost", "73d268bfd1544e7a8cf924f7511304a5"},
    {"image_given_up", "9f349c93260c4a62b6a98f3785cdf81b"},
    {"image_begins_anew", "d3332c207abe4867b4d67bd3c075b8c5"},
    {"image_refused", "b46cfbee661c48c5b7294e9ef650da08"},
    {"telegrams_left_out", "e823bef700d34b839d11b98c5ba103b0"},
    {"telegrams_left_out_over", "ca47e9944b224f7aaa7480ce786de2c9"},
    {"run_lead_changed", "e4668ce28e544be3abf0047d98238883"},
    // the CAN bus
    {"second_master", "96bc8b5a34904d9b93c9639b2adbac1a"},
    {"second_master_gone", "07abff7994394078b133056f27d3cfdf"},
    {"controller_changed", "fa4b42c9ef8f4a1ca47aed1079faf35e"},
    {"sending_failed", "8d942348e0af4192b08faed8f380f51c"},
    {"sending_restored", "b5a8b768cc9846eb96961ad34bade764"},
    {"interface_up", "3c61d6ac0bcb4b78a071729450d599c5"},
    {"interface_down", "a8ef0d1b320a4994add6a0829ef34ac6"},
    {"interface_missing", "1fe482f047ca497bb0c7cafb072b4a4b"},
    {"wrong_adapter", "dc8121735ba148c685e6c4634311eaa0"},
    {"wrong_bit_rate", "cf6a76d6b3c842c0bdc2611614106605"},
    {"listen_only", "3931817e97384a019c399602e19bb586"},
    {"not_one_shot", "8b7f0f256679406bace8bd8946fae098"},
    {"not_delivered", "242e264ee13b4abe874444ee43028739"},
    {"not_emptied", "b0f0de088c314467960e76f0056ab510"},
    {"delivered_again", "602faef3016e4be7ac35c346aed2f346"},
    {"not_acknowledged", "619022ccdfe044658684d9863e31cbb7"},
    {"acknowledged", "4ad61bf0dc0643159c57e16d3352c127"},
    {"bus_errors", "d248e0e3dfe949b59da470870bdbe6e9"},
    {"bus_errors_over", "28b9c167300c4f59841288bac8df8f0c"},
    {"controller_overrun", "c7b17d376df94e80842a007b5b846072"},
    {"controller_overrun_over", "10db216628df429c92eaf497d6fda462"},
    {"frames_dropped", "ba0bceb15922428fbdaf4f9f0d8d9724"},
    {"frames_dropped_over", "3ea03a2f8b834e4383500f76f69518ec"},
    {"bus_fault", "abd6d6fcaa5147a9a2db220db27293de"},
    {"bus_fault_over", "f86942f7e51c4663afd974f17b97a8e0"},
    // nodes that claim addresses and tell faults
    {"address_claimed", "4c43a5a89f9b487b8095cea390c8f327"},
    {"address_lost", "14779f5edf4f4b0a97c232b421d9aa13"},
    {"address_unavailable", "d37a36c542134ca181f3a1ad0d07cc55"},
    {"fault_appeared", "c6522638f1e741d5a9f5fc5d182398eb"},
    {"fault_gone", "2e430107b41240dbbbb09fb790bd0269"},
    {"groups_left_out", "1dd48f8bec92426386ca1ac145ae44fb"},
    {"groups_left_out_over", "8df79d1e71be4b57ae6302776c241fa5"},
    // the SYNC line
    {"sync_locked", "86e259bf84e64b57bc128dc78254224c"},
    {"sync_holdover", "cb029114c4e841078425f2260366f358"},
    {"sync_lost", "c6c101f620ee45db84e7a9d191012f30"},
    {"sync_searching", "7c9d73c1ca274f41b7502ed07c487283"},
    {"sync_output_failed", "12c5cf47603c4b34ad3a71008262e2bf"},
    {"sync_output_restored", "01e8d9077a8c4f0d84150fffe29596fb"},
    {"sync_input_failed", "ef92a9beea1a489fa9c041b8ab9076ee"},
    {"sync_input_restored", "f887b1f106df4e13bee985c37347bc86"},
    // requests of clients
    {"request_done", "a5e0af454d2046ac823236a8a3ceb43a"},
    {"request_failed", "fde6bc2775d249e1b2c0680ed64f0898"},
    {"request_refused", "4d22371a4328470b906f8bcc88245827"},
    {"requests_not_recorded", "8d61e266469d49199a2ade0c8d37c0ea"},
    {"requests_rejected", "0fada32cd6c94fcc8f8a1488bfe3c5b3"},
    {"requests_rejected_before", "37fc1daed53740d3975c2d4a4e2f2f7c"},
    {"dds_message", "534d5472c4c1406b8383cf9c7fb2e44c"},
    {"dds_incompatible", "7f0e2c94d1b64a3c8a55e60f9b27c3d8"},
    {"replies_dropped", "c45a795a03394418ba1322dc14a62b9a"},
    {"client_gone", "046050657caf4dcaad40a65074333620"},
    {"identity_ending", "6b37a7b0aa0c46cb88da9c3572374b68"},
    {"identity_ended", "02619f423149489e94004d0143b13e0f"},
    {"second_daemon", "0bfd64e6d9514ecc9a1e4690cffb48a2"},
    {"second_daemon_gone", "2c0a25ee6c9045208886535c4c8b3ee3"},
};

/// One of `kEventKinds`. A word that is not in the table does not compile.
class EventCode {
 public:
  template <std::size_t N>
  // Implicit: a literal stands for its kind.
  consteval EventCode(const char (&word)[N]) : kind_(known({word, N - 1})) {}

  constexpr std::string_view word() const noexcept { return kind_->code; }
  constexpr std::string_view message_id() const noexcept { return kind_->id; }
  // Implicit: goes wherever the word goes.
  constexpr operator std::string_view() const noexcept { return kind_->code; }

  template <std::convertible_to<std::string_view> Text>
  friend constexpr bool operator==(EventCode kind, const Text& word) noexcept {
    return kind.word() == std::string_view(word);
  }

 private:
  static consteval const EventKind* known(std::string_view word) {
    for (const EventKind& kind : kEventKinds) {
      if (kind.code == word) return &kind;
    }
    throw "this word has no message id: add it to kEventKinds and to systemd/cansyncd.catalog";
  }

  const EventKind* kind_;
};

}  // namespace cansyncd
