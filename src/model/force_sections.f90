!> Sections for section forces. Sections and load points of each flexible body, and the coefficients for the section forces of a
!> motion and loads. Floor: model.
module limber_model_force_sections
   use limber_base_error, only: error_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_origin, only: origin_type
   use limber_beam_plane_frame, only: frame_type, beam_frame
   use limber_beam_force_recovery, only: section_type, load_place_type, recovery_type, new_recovery, exact_recovery, all_sections
   use limber_model_quantities, only: is_internal_force
   use limber_model_model, only: place_on_beam, model_type, body_type
   use limber_model_distributed_loads, only: spread_parts
   use limber_base_kinds, only: wp
   implicit none
   private
   public :: add_recoveries, recover_stations, recover_points

contains

   !> Computes the coefficients for all points with section forces in a channel, and for envelopes.
   subroutine add_recoveries(model, diagnostics)
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: sections(size(model%bodies)), i, j
      sections = 0
      do i = 1, size(model%channels)
         do j = 1, size(model%channels(i)%quantities)
            associate (quantity => model%channels(i)%quantities(j))
               if (.not. is_internal_force(quantity%kind)) cycle
               associate (point => model%points(quantity%of))
                  if (point%section > 0) cycle
                  sections(point%body) = sections(point%body) + 1
                  point%section = sections(point%body)
               end associate
            end associate
         end do
      end do
      do i = 1, size(model%bodies)
         model%bodies(i)%point_sections = sections(i)
         if (sections(i) > 0 .or. model%bodies(i)%envelope) call add_recovery(model, i, sections(i), diagnostics)
      end do
   end subroutine add_recoveries

   !> Computes the coefficients of one body. Its sections lie just before their points, seen from the start; at the start just
   !> behind.
   subroutine add_recovery(model, index, count, diagnostics)
      type(model_type), intent(inout) :: model
      !> Index of the body, and its number of sections at points
      integer, intent(in) :: index, count
      type(diagnostics_type), intent(inout) :: diagnostics
      type(section_type) :: at_points(count)
      type(section_type), allocatable :: sections(:)
      type(load_place_type), allocatable :: places(:)
      type(frame_type) :: frame
      type(error_type), allocatable :: error
      real(wp), allocatable :: shape(:, :, :)
      integer :: i
      do i = 1, size(model%points)
         associate (point => model%points(i))
            if (point%body /= index .or. point%member == 0) cycle
            if (point%section > 0) at_points(point%section) = section_type(point%member, point%along, .not. point%along > 0.0_wp)
         end associate
      end do
      sections = at_points
      allocate (places(own_points(model, index)))
      associate (body => model%bodies(index))
         call mesh_of(body, frame, shape)
         if (body%envelope) sections = [sections, all_sections(frame, acted_places(model, index), envelope_intervals(model, index))]
         ! The tension enters along the whole axis
         if (body%reduced%is_exact) sections = [sections, stations_of(model, index)]
         call spread_places(model, index, sections, places)
         if (body%reduced%is_exact) then
            call exact_recovery(sections, places, body%recovery)
            body%recovery%axis = body%reduced%exact%stations
            return
         end if
         call new_recovery(frame, shape, body%reduced, sections, places, body%recovery, error)
         if (allocated(error)) call diagnostics%add(origin_type(file=1), "internal forces of '"//body%name//"': "//error%message)
      end associate
   end subroutine add_recovery

   !> The mesh of a body with modes, a straight beam as a frame of one member, and the shapes of its coordinates.
   subroutine mesh_of(body, frame, shape)
      type(body_type), intent(in) :: body
      type(frame_type), intent(out) :: frame
      !> (3, nodes, n)
      real(wp), allocatable, intent(out) :: shape(:, :, :)
      if (body%is_frame) then
         frame = body%mesh
         shape = body%shape
      else
         call beam_frame(body%beam, body%choice%support, body%choice%origin, body%field, frame, shape)
      end if
   end subroutine mesh_of

   !> Places of a body at which section forces or stresses may have a jump or a corner: its points, the ends of distributed loads,
   !> concentrated masses, changes of the cross-section. For envelopes.
   pure function acted_places(model, index) result(places)
      type(model_type), intent(in) :: model
      integer, intent(in) :: index
      type(section_type), allocatable :: places(:)
      integer :: i, k
      allocate (places(0))
      do i = 1, size(model%points)
         associate (point => model%points(i))
            if (point%body /= index .or. point%member == 0) cycle
            places = [places, section_type(point%member, point%along)]
            do k = 1, size(model%spreads)
               if (model%spreads(k)%point == i) places = [places, section_type(point%member, model%spreads(k)%ends(1)), &
                  & section_type(point%member, model%spreads(k)%ends(2))]
            end do
         end associate
      end do
      associate (body => model%bodies(index))
         if (allocated(body%fibres%at)) places = [places, [(section_type(1, body%fibres%at(i)), i=1, ubound(body%fibres%at, 1))]]
         if (body%reduced%is_exact) places = [places, [(section_type(1, body%reduced%exact%lump_at(i)), &
            & i=1, size(body%reduced%exact%lump_at))]]
      end associate
   end function acted_places

   !> Least number of equal intervals per member in an envelope: enough for the maximum of a parabola and of the highest function;
   !> more if a point slides along the body, because its force has no fixed place.
   pure integer function envelope_intervals(model, index) result(intervals)
      type(model_type), intent(in) :: model
      integer, intent(in) :: index
      integer, parameter :: least = 40, for_each = 4, for_slides = 200
      integer :: i
      intervals = least
      if (model%bodies(index)%reduced%is_exact) intervals = max(least, for_each*model%bodies(index)%reduced%exact%angles)
      do i = 1, size(model%joints)
         if (model%joints(i)%place /= place_on_beam) cycle
         if (model%points(model%joints(i)%points(2))%body == index) intervals = max(intervals, for_slides)
      end do
   end function envelope_intervals

   !> Sections at all stations of an exact beam.
   pure function stations_of(model, index) result(sections)
      type(model_type), intent(in) :: model
      !> Index of the body
      integer, intent(in) :: index
      type(section_type) :: sections(model%bodies(index)%reduced%exact%stations)
      sections%x = model%bodies(index)%reduced%exact%s
   end function stations_of

   !> Section forces at all stations of an exact beam.
   subroutine recover_stations(model, index, recovery)
      type(model_type), intent(in) :: model
      !> Index of the body
      integer, intent(in) :: index
      type(recovery_type), intent(out) :: recovery
      type(section_type) :: sections(model%bodies(index)%reduced%exact%stations)
      type(load_place_type), allocatable :: places(:)
      sections = stations_of(model, index)
      allocate (places(own_points(model, index)))
      call spread_places(model, index, sections, places)
      call exact_recovery(sections, places, recovery)
   end subroutine recover_stations

   !> Section forces of a body with modes at some of its points, on both sides of each.
   subroutine recover_points(model, index, points, recovery, error)
      type(model_type), intent(in) :: model
      !> Indices of the body and of the points
      integer, intent(in) :: index, points(:)
      type(recovery_type), intent(out) :: recovery
      type(error_type), allocatable, intent(out) :: error
      type(section_type), allocatable :: sections(:)
      type(load_place_type), allocatable :: places(:)
      type(frame_type) :: frame
      real(wp), allocatable :: shape(:, :, :)
      integer :: i
      allocate (sections(0))
      do i = 1, size(points)
         associate (point => model%points(points(i)))
            if (point%along > 0.0_wp) sections = [sections, section_type(point%member, point%along, .false.)]
            if (point%along < length_of(point%member)) sections = [sections, section_type(point%member, point%along, .true.)]
         end associate
      end do
      allocate (places(own_points(model, index)))
      associate (body => model%bodies(index))
         call mesh_of(body, frame, shape)
         call spread_places(model, index, sections, places)
         call new_recovery(frame, shape, body%reduced, sections, places, recovery, error)
      end associate

   contains

      !> Length of a member, less what tells no place from its end.
      pure real(wp) function length_of(member)
         integer, intent(in) :: member
         real(wp), parameter :: near = 1.0e-9_wp
         associate (body => model%bodies(index))
            length_of = body%beam%length
            if (body%is_frame) length_of = sum(body%mesh%length, mask=body%mesh%member == member)
         end associate
         length_of = (1 - near)*length_of
      end function length_of

   end subroutine recover_points

   !> Fills the load places of a body: its points, and points that stand for loads along a member.
   subroutine spread_places(model, index, sections, places)
      type(model_type), intent(in) :: model
      integer, intent(in) :: index
      type(section_type), intent(in) :: sections(:)
      type(load_place_type), intent(inout) :: places(:)
      integer :: i, k, place
      place = 0
      do i = 1, size(model%points)
         if (model%points(i)%body /= index .or. model%points(i)%member == 0) cycle
         place = place + 1
         places(place)%member = model%points(i)%member
         places(place)%x = model%points(i)%along
         do k = 1, size(model%spreads)
            if (model%spreads(k)%point == i) call spread_parts(model%spreads(k), model%bodies(index), &
               & pack(sections%x, sections%member == places(place)%member), places(place)%at, places(place)%part)
         end do
      end do
   end subroutine spread_places

   !> Number of points on the members of a body.
   pure integer function own_points(model, index)
      type(model_type), intent(in) :: model
      integer, intent(in) :: index
      integer :: i
      own_points = 0
      do i = 1, size(model%points)
         if (model%points(i)%body == index .and. model%points(i)%member > 0) own_points = own_points + 1
      end do
   end function own_points

end module limber_model_force_sections
