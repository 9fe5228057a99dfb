// A DDS program of another make (Fast DDS 2.9 of Debian) that sends impact events to a twin and listens to it, on 127.0.0.1 only.
// tests/security/fast_dds.rs compiles and starts it:
//
//   peer DOMAIN SECONDS COLUMN_ID EVENT_PREFIX [ENCLAVE_FOLDER [CLOCK_OFFSET_SECONDS [credulous]]]
//
// Without a folder it has no DDS security. With a clock offset it believes that it is another time, as an attacker would whose
// certificate has expired; a credulous one takes every certificate for genuine, its own and the twin's, so that it goes through
// the handshake with any. If the folder holds own_permissions.p7s, its own stack obeys those, and it shows the others,
// permissions.p7s, to the twin: it skips its own checks and nothing else. It sends an event every 0.1 s, whether there is a reader or not, until it has received a forecast of one
// of its own events or the time is over, and prints one line of JSON: which entities its own security let it create, how many
// writers and readers it was matched with, what it sent, how many samples it received by topic, and the counts of the last
// twin_status.
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <dlfcn.h>
#include <fstream>
#include <iostream>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <openssl/bio.h>
#include <openssl/x509_vfy.h>

using namespace eprosima::fastdds::dds;
using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;
using eprosima::fastrtps::rtps::InstanceHandle_t;
using eprosima::fastrtps::rtps::SerializedPayload_t;

static long clock_offset = 0;
static bool credulous = false;
// The permissions that its own stack obeys, if they are not those that it shows.
static std::string own_permissions;

// The three functions below are called by the libraries, because those of the program come before theirs.

// OpenSSL asks this one whether a certificate has expired.
extern "C" time_t time(time_t* result) noexcept {
  using Time = time_t (*)(time_t*);
  static const Time real = reinterpret_cast<Time>(dlsym(RTLD_NEXT, "time"));
  const time_t now = real(nullptr) + clock_offset;
  if (result != nullptr) *result = now;
  return now;
}

// Fast DDS asks this one of OpenSSL whether a certificate is genuine.
extern "C" int X509_verify_cert(X509_STORE_CTX* context) {
  using Verify = int (*)(X509_STORE_CTX*);
  static const Verify real = reinterpret_cast<Verify>(dlsym(RTLD_NEXT, "X509_verify_cert"));
  return credulous ? 1 : real(context);
}

// Fast DDS reads with this one of OpenSSL what it obeys itself; what it shows to others it reads with a stream of C++.
extern "C" BIO* BIO_new_file(const char* path, const char* mode) {
  using Open = BIO* (*)(const char*, const char*);
  static const Open real = reinterpret_cast<Open>(dlsym(RTLD_NEXT, "BIO_new_file"));
  static const std::string shown = "/permissions.p7s";
  const std::string asked = path;
  const bool is_shown = asked.size() >= shown.size() && asked.compare(asked.size() - shown.size(), shown.size(), shown) == 0;
  return real(is_shown && !own_permissions.empty() ? own_permissions.c_str() : path, mode);
}

// An encoded message, with its encapsulation.
using Bytes = std::vector<char>;

// Passes encoded messages through.
class Encoded : public TopicDataType {
 public:
  explicit Encoded(const char* name) {
    setName(name);
    m_typeSize = 65536;
    m_isGetKeyDefined = false;
    auto_fill_type_object(false);
    auto_fill_type_information(false);
  }
  bool serialize(void* data, SerializedPayload_t* payload) override {
    const auto& bytes = *static_cast<Bytes*>(data);
    payload->encapsulation = CDR_LE;
    payload->length = bytes.size();
    std::copy(bytes.begin(), bytes.end(), payload->data);
    return true;
  }
  bool deserialize(SerializedPayload_t* payload, void* data) override {
    static_cast<Bytes*>(data)->assign(payload->data, payload->data + payload->length);
    return true;
  }
  std::function<uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<uint32_t>(static_cast<Bytes*>(data)->size()); };
  }
  void* createData() override { return new Bytes; }
  void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
  bool getKey(void*, InstanceHandle_t*, bool) override { return false; }
};

// column_twin_msgs/msg/ImpactEvent: 100 kg at 0.5 m/s, which leaves no damage; the parameters give the rest.
static Bytes impact_event(const std::string& column, const std::string& event) {
  char memory[1024];
  FastBuffer buffer(memory, sizeof memory);
  Cdr cdr(buffer, Cdr::LITTLE_ENDIANNESS, Cdr::DDS_CDR);
  cdr.serialize_encapsulation();
  // The true time: the twin rejects events of another.
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const auto nanos = std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
  cdr << static_cast<int32_t>(nanos / 1000000000) << static_cast<uint32_t>(nanos % 1000000000);
  const double open = std::nan("");
  cdr << std::string() << column << event << std::string("rigid") << 100.0 << 0.5 << open << open << open << open;
  return Bytes(memory, memory + cdr.getSerializedDataLength());
}

// The event_id of a column_twin_msgs/msg/ImpactReport.
static std::string event_of(Bytes& report) {
  FastBuffer buffer(report.data(), report.size());
  Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
  cdr.read_encapsulation();
  int32_t sec;
  uint32_t nanosec;
  std::string frame, column, event;
  cdr >> sec >> nanosec >> frame >> column >> event;
  return event;
}

// The counts of a column_twin_msgs/msg/TwinStatus.
static std::map<std::string, uint64_t> counts_of(Bytes& status) {
  FastBuffer buffer(status.data(), status.size());
  Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
  cdr.read_encapsulation();
  int32_t sec;
  uint32_t nanosec;
  uint8_t phase;
  std::string frame, column, event;
  uint64_t accepted, merged, rejected;
  cdr >> sec >> nanosec >> frame >> column >> phase >> event >> accepted >> merged >> rejected;
  return {{"events_accepted", accepted}, {"events_rejected", rejected}};
}

// Counts what comes, and remembers the events of forecasts.
struct Received : DataReaderListener {
  std::mutex mutex;
  std::map<std::string, int> samples;
  std::map<std::string, uint64_t> status;
  std::set<std::string> forecast;

  void on_data_available(DataReader* reader) override {
    Bytes bytes;
    SampleInfo info;
    const std::string topic = reader->get_topicdescription()->get_name();
    while (reader->take_next_sample(&bytes, &info) == ReturnCode_t::RETCODE_OK) {
      const std::lock_guard<std::mutex> lock(mutex);
      if (!info.valid_data) continue;
      samples[topic]++;
      if (topic == "rt/impact_forecast") forecast.insert(event_of(bytes));
      if (topic == "rt/twin_status") status = counts_of(bytes);
    }
  }
  bool accepted() {
    const std::lock_guard<std::mutex> lock(mutex);
    return status["events_accepted"] > 0;
  }
  bool knows(const std::string& prefix) {
    const std::lock_guard<std::mutex> lock(mutex);
    for (const auto& event : forecast)
      if (event.rfind(prefix, 0) == 0) return true;
    return false;
  }
};

static DomainParticipantQos loopback_only(int domain) {
  DomainParticipantQos qos = PARTICIPANT_QOS_DEFAULT;
  auto transport = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  transport->interfaceWhiteList.push_back("127.0.0.1");
  qos.transport().use_builtin_transports = false;
  qos.transport().user_transports.push_back(transport);
  // Every participant on this machine, by the port formula of RTPS 9.6.1.1.
  for (int participant = 0; participant < 12; participant++) {
    eprosima::fastrtps::rtps::Locator_t locator;
    eprosima::fastrtps::rtps::IPLocator::setIPv4(locator, "127.0.0.1");
    locator.port = 7400 + 250 * domain + 10 + 2 * participant;
    qos.wire_protocol().builtin.initialPeersList.push_back(locator);
  }
  return qos;
}

static void secure(DomainParticipantQos& qos, const std::string& folder) {
  const auto set = [&](const std::string& name, const std::string& value) {
    qos.properties().properties().emplace_back("dds.sec." + name, value);
  };
  const auto file = [&](const char* name) { return "file://" + folder + "/" + name; };
  set("auth.plugin", "builtin.PKI-DH");
  set("auth.builtin.PKI-DH.identity_ca", file("identity_ca.cert.pem"));
  set("auth.builtin.PKI-DH.identity_certificate", file("cert.pem"));
  set("auth.builtin.PKI-DH.private_key", file("key.pem"));
  set("crypto.plugin", "builtin.AES-GCM-GMAC");
  set("access.plugin", "builtin.Access-Permissions");
  set("access.builtin.Access-Permissions.permissions_ca", file("permissions_ca.cert.pem"));
  set("access.builtin.Access-Permissions.governance", file("governance.p7s"));
  set("access.builtin.Access-Permissions.permissions", file("permissions.p7s"));
}

int main(int argc, char** argv) {
  if (argc < 5) {
    std::cerr << "usage: peer DOMAIN SECONDS COLUMN_ID EVENT_PREFIX [ENCLAVE_FOLDER [CLOCK_OFFSET_SECONDS [credulous]]]\n";
    return 2;
  }
  const int domain = std::atoi(argv[1]);
  const std::chrono::seconds patience(std::atoi(argv[2]));
  const std::string column = argv[3], prefix = argv[4];
  DomainParticipantQos qos = loopback_only(domain);
  if (argc > 5) {
    secure(qos, argv[5]);
    const std::string own = argv[5] + std::string("/own_permissions.p7s");
    if (std::ifstream(own).good()) own_permissions = own;
  }
  if (argc > 6) clock_offset = std::atol(argv[6]);
  credulous = argc > 7 && argv[7] == std::string("credulous");

  Received received;
  std::map<std::string, bool> created;
  int sent = 0, matched_readers = 0, matched_writers = 0;
  auto* factory = DomainParticipantFactory::get_instance();
  auto* participant = factory->create_participant(domain, qos);
  created["participant"] = participant != nullptr;
  if (participant != nullptr) {
    auto* subscriber = participant->create_subscriber(SUBSCRIBER_QOS_DEFAULT);
    DataReaderQos reader_qos = DATAREADER_QOS_DEFAULT;
    reader_qos.reliability().kind = RELIABLE_RELIABILITY_QOS;
    reader_qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    std::vector<DataReader*> readers;
    const auto read = [&](const char* topic, const char* type, bool late) {
      participant->register_type(TypeSupport(new Encoded(type)));
      auto* described = participant->create_topic(topic, type, TOPIC_QOS_DEFAULT);
      reader_qos.durability().kind = late ? TRANSIENT_LOCAL_DURABILITY_QOS : VOLATILE_DURABILITY_QOS;
      auto* reader = subscriber->create_datareader(described, reader_qos, &received);
      created[topic] = reader != nullptr;
      if (reader != nullptr) readers.push_back(reader);
    };
    read("rt/twin_status", "column_twin_msgs::msg::dds_::TwinStatus_", true);
    read("rt/impact_forecast", "column_twin_msgs::msg::dds_::ImpactReport_", true);
    read("rt/column_state", "column_twin_msgs::msg::dds_::ColumnState_", false);

    const char* event_type = "column_twin_msgs::msg::dds_::ImpactEvent_";
    participant->register_type(TypeSupport(new Encoded(event_type)));
    auto* topic = participant->create_topic("rt/impact_event", event_type, TOPIC_QOS_DEFAULT);
    DataWriterQos writer_qos = DATAWRITER_QOS_DEFAULT;
    writer_qos.reliability().kind = RELIABLE_RELIABILITY_QOS;
    writer_qos.durability().kind = VOLATILE_DURABILITY_QOS;
    writer_qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    auto* writer = participant->create_publisher(PUBLISHER_QOS_DEFAULT)->create_datawriter(topic, writer_qos);
    created["rt/impact_event"] = writer != nullptr;

    const auto deadline = std::chrono::steady_clock::now() + patience;
    // A status is sent once a second, so the last one tells what became of the first event.
    const auto is_done = [&] { return received.knows(prefix) && received.accepted(); };
    while (std::chrono::steady_clock::now() < deadline && !is_done()) {
      if (writer != nullptr) {
        Bytes event = impact_event(column, prefix + "-" + std::to_string(sent));
        sent += writer->write(&event) ? 1 : 0;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    if (writer != nullptr) {
      PublicationMatchedStatus status;
      writer->get_publication_matched_status(status);
      matched_readers = status.total_count;
    }
    for (auto* reader : readers) {
      SubscriptionMatchedStatus status;
      reader->get_subscription_matched_status(status);
      matched_writers += status.total_count;
    }
    participant->delete_contained_entities();
    factory->delete_participant(participant);
  }

  const auto object = [](const auto& map) {
    std::string json;
    for (const auto& [name, value] : map) json += (json.empty() ? "\"" : ",\"") + name + "\":" + std::to_string(value);
    return "{" + json + "}";
  };
  std::cout << "{\"created\":" << object(created) << ",\"sent\":" << sent << ",\"matched_readers\":" << matched_readers
            << ",\"matched_writers\":" << matched_writers << ",\"received\":" << object(received.samples)
            << ",\"status\":" << object(received.status)
            << ",\"forecasts_of_own_events\":" << (received.knows(prefix) ? 1 : 0) << "}\n";
}
